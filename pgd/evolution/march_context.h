#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/evolution/slab_collocation.h"
#include "samara/pgd/evolution/slab_evolution.h"
#include "samara/pgd/evolution/slab_solver.h"

namespace samara::pgd {

/// What a slab may add to the error, in scales: slabs with features that no polynomial follows, which are
/// few, may err by more than the smooth ones, which are many and cost little.
struct LocalTolerance {
  double wanted = 0.0;
  double largest = 0.0;
};

/// What all parts of a march share: what is solved, how well, and the collocation at single points, whose
/// evaluations are counted.
class MarchContext {
 public:
  static constexpr int kTimePoints = 8;  ///< Radau points of an element of time

  /// @param scales what errors are measured in. Problem, options and solver must outlive the context.
  MarchContext(const AdaptiveProblem& problem, const SlabOptions& options, const SlabSolver& solver,
               const Eigen::VectorXd& scales, LocalTolerance tolerance);

  const AdaptiveProblem& problem() const { return problem_; }
  const SlabOptions& options() const { return options_; }
  const Eigen::VectorXd& scales() const { return scales_; }
  /// The largest absolute value of every state at t = 0, in scales: an offset may be far larger than the range.
  const Eigen::VectorXd& start_sizes() const { return start_sizes_; }
  int states() const { return static_cast<int>(scales_.size()); }
  const SlabTime& time() const { return collocation_.time(); }
  /// What a slab may add to the error, and by how much more, as a factor, one with a kink.
  double tolerance() const { return tolerance_; }
  double most_lenient() const { return most_lenient_; }
  /// The longest slabs, and the shortest elements that are tried.
  double longest() const;
  double shortest() const;

  const SlabSolver& solver() const { return solver_; }
  /// Euclidean tolerance at which a train over the nodes of the cell is rounded.
  double rounding(const SlabCell& cell, const TensorTrain& train) const;

  /// Whether the caller wants the march to end. @param stage of the march, if there is a new one
  bool is_cancelled(std::optional<Progress> stage = {});

  /// Solutions on elements from `start` (states x points, over their scales) at q (parameters x points).
  SlabPoints solve(const std::vector<double>& borders, const Eigen::MatrixXd& start,
                   const Eigen::MatrixXd& q);
  /// What a solver has evaluated by itself.
  void count(long evaluations) { evaluations_ += evaluations; }
  /// Of f and J since take_evaluations() was called last.
  long evaluations() const { return evaluations_; }
  long take_evaluations();

 private:
  const AdaptiveProblem& problem_;
  const SlabOptions& options_;
  const SlabSolver& solver_;
  const Eigen::VectorXd scales_;
  const Eigen::VectorXd start_sizes_;
  const double tolerance_;
  const double most_lenient_;
  const SlabCollocation collocation_;
  long evaluations_ = 0;
  Progress stage_;
};

}  // namespace samara::pgd
