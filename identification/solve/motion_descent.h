#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/descent_steps.h"
#include "samara/identification/solve/motion_terms.h"
#include "samara/identification/solve/secant_model.h"

/// Internal to identification/.
namespace samara::identification {

/// One motion of a descent (separable_descent.h), its own unknowns in the slots of the point that belong to it.
class MotionDescent {
 public:
  MotionDescent(const FitProblem& problem, std::vector<SegmentResidual>& residuals, const Motion& motion)
      : problem_(&problem), residuals_(&residuals), motion_(&motion) {}

  /// Cost at the point of all; infinite where a residual is not finite, as without a trajectory.
  double cost_at(const FitPoint& point) const;

  /// Slopes at the point.
  /// @returns false where a residual or a slope is not finite: then those of before are kept
  bool linearise(const FitPoint& point);

  void start_at(const FitPoint& point);

  /// Steps of the own unknowns, the shared ones held.
  /// @param allowance of the decrement, for settled()
  void settle(FitPoint& point, int most_steps, double allowance);

  /// One step more, as far as rounding allows.
  void polish(FitPoint& point);

  /// Solved for how own unknowns follow the shared ones, and for what is left for these: by J^T W J, which is
  /// never negative. What that lacks the shared ones learn themselves.
  void eliminate();

  const Eigen::VectorXd& reduced_gradient() const { return reduced_gradient_; }
  const Eigen::MatrixXd& reduced_normal() const { return reduced_normal_; }

  /// Own unknowns follow a step of the shared ones that `point` has taken already; where they better stay,
  /// they stay. After eliminate().
  /// @returns false if residuals and slopes are not finite either way
  bool follow(FitPoint& point, const Eigen::VectorXd& shared_step);

  double weight() const { return motion_->weight; }
  double cost() const { return cost_; }
  bool settled() const { return settled_; }
  int steps() const { return steps_; }
  double psi_squares() const { return psi_squares_; }
  double dpsi_sum() const { return dpsi_sum_; }
  int free_count() const { return static_cast<int>(free_.size()); }

 private:
  std::size_t first() const { return motion_->first_segment; }
  std::size_t last() const { return motion_->first_segment + motion_->segment_count; }

  bool evaluate(const FitPoint& point, bool with_derivatives) const;

  static Eigen::VectorXd weights_of(const MotionEquations& equations);

  void find_free(const FitPoint& point);

  std::vector<Eigen::VectorXd> own_of(const FitPoint& point) const;

  void move(FitPoint& point, const Eigen::VectorXd& step) const;

  /// The step that was taken, which bounds may have cut.
  Eigen::VectorXd taken(const std::vector<Eigen::VectorXd>& before, const FitPoint& point) const;

  /// @returns false if no damping lowers the cost
  bool step(FitPoint& point);

  const FitProblem* problem_;
  std::vector<SegmentResidual>* residuals_;
  const Motion* motion_;
  double cost_ = 0.0;
  double damping_ = kFirstDamping;
  bool settled_ = false;
  int steps_ = 0;
  std::vector<int> free_;
  SecantModel own_;
  Eigen::VectorXd by_shared_, by_own_;
  Eigen::MatrixXd shared_normal_, cross_;
  Eigen::MatrixXd response_;
  Eigen::VectorXd rest_, reduced_gradient_;
  Eigen::MatrixXd reduced_normal_;
  double psi_squares_ = 0.0, dpsi_sum_ = 0.0;
};

}  // namespace samara::identification
