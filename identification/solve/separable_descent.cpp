#include "samara/identification/solve/separable_descent.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "samara/base/parallel.h"
#include "samara/identification/solve/motion_descent.h"

namespace samara::identification {

namespace {

/// Noise of a millionth of the loss scale is none.
constexpr double kLeastDispersion = 1e-12;
/// Of the own unknowns, for each step of the shared ones.
constexpr int kOwnSteps = 60;

class SeparableDescent {
 public:
  SeparableDescent(const FitProblem& problem, std::vector<SegmentResidual>& residuals, FitPoint start,
                   double share)
      : problem_(problem), residuals_(residuals), point_(std::move(start)), share_(share) {
    for (const Motion& motion : problem.motions) motions_.emplace_back(problem, residuals, motion);
  }

  MinimizeResult run(int max_iterations) {
    each_motion([&](MotionDescent& motion) { motion.start_at(point_); });
    if (!std::isfinite(total())) {
      const std::string failure = failure_of(residuals_);
      return {.point = std::move(point_),
              .message = failure.empty() ? "the cost is not a finite number" : failure};
    }
    MinimizeResult result{.status = Termination::max_iterations};
    if (problem_.shared_chart.directions() > 0) {
      settle(kOwnSteps);
      while (result.status != Termination::converged && result.iterations < max_iterations) {
        ++result.iterations;
        if (step_is_last()) result.status = Termination::converged;
      }
    } else {
      settle_alone(max_iterations, result);
    }
    if (result.status == Termination::converged) polish();
    result.message = result.status == Termination::converged
                         ? "no step would move an unknown by a noticeable share of its error"
                         : "iterations were spent";
    result.cost = total();
    result.point = std::move(point_);
    return result;
  }

 private:
  template <class Action>
  void each_motion(const Action& action) {
    parallel_for(motions_.size(), [&](std::size_t k) { action(motions_[k]); });
  }

  double total() const {
    double sum = prior_terms(problem_, point_).cost;
    for (const MotionDescent& motion : motions_) sum += motion.weight() * motion.cost();
    return sum;
  }

  bool all_settled() const { return std::ranges::all_of(motions_, &MotionDescent::settled); }

  double dispersion() const {
    double squares = 0.0, slopes = 0.0;
    int count = problem_.observation_count() - problem_.shared_chart.directions();
    for (const MotionDescent& motion : motions_) {
      squares += motion.psi_squares();
      slopes += motion.dpsi_sum();
      count -= motion.free_count();
    }
    const double mean_slope = std::max(slopes / problem_.observation_count(), 0.1);
    return std::max(squares / std::max(count, 1) / mean_slope, kLeastDispersion);
  }

  double allowance() const { return share_ * share_ * dispersion(); }

  void settle(int most_steps) {
    const double allowed = allowance();
    each_motion([&](MotionDescent& motion) { motion.settle(point_, most_steps, allowed); });
  }

  /// Where nothing is shared.
  void settle_alone(int max_iterations, MinimizeResult& result) {
    double before = 0.0;
    do {
      before = allowance();  // of residuals as they were: it shrinks as they do
      settle(max_iterations - result.iterations);
      int most = 0;
      for (const MotionDescent& motion : motions_) most = std::max(most, motion.steps());
      result.iterations += most;
    } while (allowance() < 0.5 * before && result.iterations < max_iterations);
    if (all_settled()) result.status = Termination::converged;
  }

  /// One step more than the end asks for: where the cost is smooth, it is worth many.
  void polish() {
    if (problem_.shared_chart.directions() > 0) {
      reduce();
      const double cost = total();
      if (decrement(model_, gradient_, free_) > kCostRounding * cost) try_steps(cost);
    }
    each_motion([&](MotionDescent& motion) { motion.polish(point_); });
  }

  /// The model of the cost with own unknowns eliminated.
  void reduce() {
    for (MotionDescent& motion : motions_) motion.eliminate();
    const PriorTerms priors = prior_terms(problem_, point_);
    const Eigen::MatrixXd moves = problem_.shared_chart.plus_jacobian(point_.shared.data());
    gradient_ = moves.transpose() * priors.gradient;
    Eigen::MatrixXd normal = moves.transpose() * priors.information * moves;
    for (const MotionDescent& motion : motions_) {
      gradient_ += motion.weight() * motion.reduced_gradient();
      normal += motion.weight() * motion.reduced_normal();
    }
    model_.move_to(std::move(normal));
    free_.clear();
    add_free(problem_.shared, problem_.shared_chart, point_.shared, gradient_, 0, free_);
  }

  /// @returns whether there is nothing to gain any more
  bool step_is_last() {
    const Eigen::VectorXd slope = gradient_;
    reduce();
    if (step_.size() > 0) model_.learn(step_, gradient_ - slope);
    const double cost = total();
    const double gain = decrement(model_, gradient_, free_);
    if (gain <= std::max(allowance(), kCostRounding * cost)) {
      step_.resize(0);
      if (all_settled()) return true;
      settle(kOwnSteps);
      return false;
    }
    if (try_steps(cost)) return false;
    step_.resize(0);
    return all_settled();
  }

  /// @returns whether a step lowered the cost
  bool try_steps(double cost) {
    const FitPoint before = point_;
    const std::vector<MotionDescent> motions = motions_;
    const Eigen::VectorXd scale = damping_scale(model_.normal());
    while (damping_ < kMostDamping) {
      const Eigen::MatrixXd hessian = model_.hessian();
      if (const auto wanted = damped_step(hessian, scale, gradient_, free_, damping_)) {
        point_.shared = moved(problem_.shared, problem_.shared_chart, before.shared, *wanted);
        step_ = step_between(problem_.shared_chart, before.shared, point_.shared);
        if (follow_and_settle()) {
          const double reached = total();
          if (reached < cost) {
            const double predicted = -(gradient_.dot(step_) + 0.5 * step_.dot(hessian * step_));
            damping_ = damping_after(damping_, predicted > 0.0 ? (cost - reached) / predicted : 1.0);
            return true;
          }
        }
        point_ = before;
        motions_ = motions;
      }
      harden(model_, damping_);
    }
    damping_ = kFirstDamping;
    return false;
  }

  bool follow_and_settle() {
    std::vector<char> ok(motions_.size(), 0);
    parallel_for(motions_.size(), [&](std::size_t k) { ok[k] = motions_[k].follow(point_, step_); });
    if (!std::ranges::all_of(ok, [](char one) { return one != 0; })) return false;
    settle(kOwnSteps);
    return true;
  }

  const FitProblem& problem_;
  const std::vector<SegmentResidual>& residuals_;
  FitPoint point_;
  double share_;
  std::vector<MotionDescent> motions_;
  SecantModel model_;
  Eigen::VectorXd gradient_, step_;
  std::vector<int> free_;
  double damping_ = kFirstDamping;
};

}  // namespace

MinimizeResult minimize_separably(const FitProblem& problem, std::vector<SegmentResidual>& residuals,
                                  FitPoint start, int max_iterations, double share) {
  return SeparableDescent(problem, residuals, std::move(start), share).run(max_iterations);
}

}  // namespace samara::identification
