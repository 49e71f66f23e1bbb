#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/pgd/nonlinear/strategy.h"

namespace samara::pgd {

struct IterationOptions {
  int max_iterations = 40;
  /// Of f and J, those before this slab included; no iteration begins beyond it. 0: no limit.
  long max_evaluations = 0;
  long evaluations_before = 0;
  ProgressCallback progress = {};
};

/// What an iteration has done.
struct IterationRecord {
  int iterations = 0;
  std::vector<double> corrections = {};  ///< ||X_k+1 - X_k||, root mean square over the nodes, in scales
  double contraction = 0.0;              ///< largest ratio of successive corrections above the tolerance
  std::vector<int> source_ranks = {};    ///< of b, largest over the iterations
  std::vector<int> jacobian_ranks = {};  ///< of A; empty: there was none
};

/// The iteration of a strategy on one slab, from the state that stays at the start.
class SlabIteration {
 public:
  /// @param counts of this slab, as they come
  SlabIteration(const StrategySlab& slab, IterationOptions options, const StrategyCounts& counts)
      : slab_(slab), options_(std::move(options)), counts_(counts), iterate_(slab.constant()) {}

  const TensorTrain& iterate() const { return iterate_; }
  const IterationRecord& record() const { return record_; }

  /// A few iterations of another strategy, whether they converge or not; one that fails leaves the start.
  void first_iterate(Strategy& strategy, int iterations);

  /// @returns what ended the iteration before it has converged, or nothing
  std::optional<Ending> run(Strategy& strategy);

 private:
  Outcome<double> step(Strategy& strategy);
  bool converged(double correction);
  bool diverges(const Strategy& strategy, double correction);
  std::optional<Ending> reason_to_stop() const;
  Ending ended(Termination status, const std::string& why) const;
  double fraction() const;

  const StrategySlab& slab_;
  const IterationOptions options_;
  const StrategyCounts& counts_;
  IterationRecord record_;
  TensorTrain iterate_;
  CrossPivots pivots_;
  double ratio_ = 0.0;
  bool rough_ = false;  ///< the last source was
  int growths_ = 0;
};

/// Largest |x0 + S f(X) - X|, infinite where f is not finite. @param q parameters x points @param x the iterate there
double defect_at(const StrategySlab& slab, const Eigen::MatrixXd& q, const Eigen::MatrixXd& x);

}  // namespace samara::pgd
