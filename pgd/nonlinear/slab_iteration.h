#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/nonlinear/strategy.h"
#include "samara/pgd/nonlinear/strategy_trial.h"

namespace samara::pgd {

/// The iteration of a strategy on one slab, from the state that stays at the start.
class SlabIteration {
 public:
  /// @param evaluations before this slab @param counts of this slab, as they come
  SlabIteration(const StrategySlab& slab, const StrategyTrialOptions& options, long evaluations,
                const StrategyCounts& counts, StrategyRecord& record)
      : slab_(slab),
        options_(options),
        evaluations_(evaluations),
        counts_(counts),
        record_(record),
        iterate_(slab.constant()) {}

  const TensorTrain& iterate() const { return iterate_; }

  /// A few iterations of another strategy, whether they converge or not; one that fails leaves the start.
  void first_iterate(Strategy& strategy);

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
  const StrategyTrialOptions& options_;
  const long evaluations_;  ///< before this slab
  const StrategyCounts& counts_;
  StrategyRecord& record_;
  TensorTrain iterate_;
  CrossPivots pivots_;
  double ratio_ = 0.0;
  int growths_ = 0;
};

/// Largest |x0 + S f(X) - X|, infinite where f is not finite. @param q parameters x points @param x the iterate there
double defect_at(const StrategySlab& slab, const Eigen::MatrixXd& q, const Eigen::MatrixXd& x);

}  // namespace samara::pgd
