#include "samara/identification/solve/separable_descent.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>
#include <tbb/parallel_for.h>

#include "samara/identification/problem/box_bounds.h"
#include "samara/identification/solve/motion_terms.h"
#include "samara/identification/solve/secant_model.h"
#include "samara/identification/statistics/loss.h"

namespace samara::identification {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFirstDamping = 1e-4;
constexpr double kMostDamping = 1e10;
/// Beside the Hessian of the loss, of what least squares with weights psi/r have: outliers must not leave a
/// direction without curvature.
constexpr double kWeightFloor = 0.2;
/// A relative change of a cost that rounding hides.
constexpr double kRounding = 1e-13;
/// Noise of a millionth of the loss scale is none.
constexpr double kLeastDispersion = 1e-12;
/// Of the own unknowns, for each step of the shared ones.
constexpr int kOwnSteps = 60;
/// Own unknowns are settled beyond what is asked of the end, from the first step on: what they leave is noise
/// in the slopes from which the shared ones learn. Of the allowance.
constexpr double kOwnShare = 0.01;

/// Directions of a block that are not held at a bound: those at one move only if the cost falls inwards.
void add_free(const std::vector<models::FamilyCoordinate>& box, const Chart& chart,
              const Eigen::VectorXd& values, const Eigen::Ref<const Eigen::VectorXd>& gradient, int first,
              std::vector<int>& free) {
  std::vector<char> held(static_cast<std::size_t>(chart.directions()), 0);
  const std::vector<char> at = at_bounds(box, chart, values);
  for (std::size_t k = 0; k < box.size(); ++k) {
    const int direction = chart.direction_of(static_cast<int>(k));
    if (!at[k] || direction < 0) continue;
    const double value = values[static_cast<Eigen::Index>(k)];
    const bool at_lower = value < 0.5 * (box[k].lower + box[k].upper);
    const double slope = gradient[direction];
    held[static_cast<std::size_t>(direction)] = at_lower ? slope >= 0.0 : slope <= 0.0;
  }
  for (int k = 0; k < chart.directions(); ++k) {
    if (!held[static_cast<std::size_t>(k)]) free.push_back(first + k);
  }
}

/// `values` moved by a step, and back into the box.
Eigen::VectorXd moved(const std::vector<models::FamilyCoordinate>& box, const Chart& chart,
                      const Eigen::VectorXd& values, const Eigen::Ref<const Eigen::VectorXd>& step) {
  const Eigen::VectorXd whole = step;
  Eigen::VectorXd to = values;
  chart.plus(values.data(), whole.data(), to.data());
  for (std::size_t k = 0; k < box.size(); ++k) {
    if (chart.is_part_of_quaternion(static_cast<int>(k))) continue;
    double& value = to[static_cast<Eigen::Index>(k)];
    value = std::clamp(value, box[k].lower, box[k].upper);
  }
  return to;
}

Eigen::VectorXd step_between(const Chart& chart, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  Eigen::VectorXd step(chart.directions());
  chart.minus(to.data(), from.data(), step.data());
  return step;
}

/// What the largest damping tried so far says of the next one.
double after_success(double damping, double gain_ratio) {
  if (gain_ratio > 0.75) return std::max(0.2 * damping, 1e-12);
  return gain_ratio < 0.25 ? 4.0 * damping : damping;
}

/// g^T H^-1 g on the free directions, by J^T W J and by what was learned, whichever is larger: twice what a
/// step could gain.
double decrement(const SecantModel& model, const Eigen::VectorXd& gradient, const std::vector<int>& free) {
  const Eigen::VectorXd scale = damping_scale(model.normal());
  double largest = 0.0;
  for (const Eigen::MatrixXd& matrix : {model.normal(), model.hessian()}) {
    const auto step = damped_step(matrix, scale, gradient, free, 1e-13);
    largest = std::max(largest, step ? -step->dot(gradient) : 0.0);
  }
  return largest;
}

/// The inverse of a matrix on the free directions, made positive if it is not.
class Solver {
 public:
  Solver(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& normal, const std::vector<int>& free)
      : free_(free), scale_(damping_scale(normal)(free).cwiseSqrt().cwiseInverse()) {
    const Eigen::MatrixXd scaled = scale_.asDiagonal() * matrix(free, free) * scale_.asDiagonal();
    for (double shift = 1e-12; shift < 1e3; shift *= 10.0) {
      Eigen::MatrixXd shifted = scaled;
      shifted.diagonal().array() += shift;
      factor_.compute(shifted);
      if (factor_.info() == Eigen::Success) return;
    }
  }

  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(right.rows(), right.cols());
    if (free_.empty()) return result;
    result(free_, Eigen::all) =
        scale_.asDiagonal() * factor_.solve(scale_.asDiagonal() * right(free_, Eigen::all));
    return result;
  }

 private:
  const std::vector<int>& free_;
  Eigen::VectorXd scale_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

/// One motion, its own unknowns in the slots of the point that belong to it.
class MotionDescent {
 public:
  MotionDescent(const FitProblem& problem, std::vector<SegmentResidual>& residuals, const Motion& motion)
      : problem_(&problem), residuals_(&residuals), motion_(&motion) {}

  /// Cost at the point of all; infinite without a trajectory.
  double cost_at(const FitPoint& point) const {
    if (!evaluate(point, false)) return kInfinity;
    double sum = 0.0;
    for (std::size_t k = first(); k < last(); ++k) {
      const SegmentResidual& residual = (*residuals_)[k];
      for (int row = 0; row < residual.size(); ++row) {
        const double r = residual.residual()[row];
        sum += row < residual.data_size() ? loss_value(problem_->loss, r).rho : r * r;
      }
    }
    return 0.5 * sum;
  }

  /// Slopes at the point.
  /// @returns false without a trajectory
  bool linearise(const FitPoint& point) {
    if (!evaluate(point, true)) return false;
    const MotionEquations equations = motion_equations(*problem_, *motion_, *residuals_, point);
    const Eigen::MatrixXd J_s =
        equations.by_shared * problem_->shared_chart.plus_jacobian(point.shared.data());
    const Eigen::MatrixXd& J_o = equations.by_own;
    const Eigen::VectorXd weights = weights_of(equations);
    by_shared_ = J_s.transpose() * equations.psi;
    by_own_ = J_o.transpose() * equations.psi;
    shared_normal_ = J_s.transpose() * weights.asDiagonal() * J_s;
    cross_ = J_o.transpose() * weights.asDiagonal() * J_s;
    own_.move_to(J_o.transpose() * weights.asDiagonal() * J_o);
    psi_squares_ = equations.psi_squares;
    dpsi_sum_ = equations.dpsi_sum;
    find_free(point);
    return true;
  }

  void start_at(const FitPoint& point) {
    cost_ = cost_at(point);
    if (cost_ < kInfinity && !linearise(point)) cost_ = kInfinity;
  }

  /// Steps of the own unknowns, the shared ones held.
  /// @param allowance of the decrement, for settled()
  void settle(FitPoint& point, int most_steps, double allowance) {
    for (steps_ = 0;; ++steps_) {
      const double gain = decrement(own_, by_own_, free_);
      settled_ = gain <= std::max(allowance, kRounding * cost_);
      if (gain <= std::max(kOwnShare * allowance, kRounding * cost_) || steps_ == most_steps) return;
      if (!step(point)) {
        settled_ = true;  // nothing lowers the cost
        return;
      }
    }
  }

  /// One step more, as far as rounding allows.
  void polish(FitPoint& point) {
    if (decrement(own_, by_own_, free_) > kRounding * cost_) step(point);
  }

  /// Solved for how own unknowns follow the shared ones, and for what is left for these: by J^T W J, which is
  /// never negative. What that lacks the shared ones learn themselves.
  void eliminate() {
    const Solver solver(own_.hessian(), own_.normal(), free_);
    response_ = solver.solve(cross_);
    rest_ = solver.solve(by_own_);
    reduced_gradient_ = by_shared_ - cross_.transpose() * rest_;
    const Solver normal(own_.normal(), own_.normal(), free_);
    reduced_normal_ = shared_normal_ - cross_.transpose() * normal.solve(cross_);
  }

  const Eigen::VectorXd& reduced_gradient() const { return reduced_gradient_; }
  const Eigen::MatrixXd& reduced_normal() const { return reduced_normal_; }

  /// Own unknowns follow a step of the shared ones that `point` has taken already; where they better stay,
  /// they stay. After eliminate().
  /// @returns false if there is no trajectory either way
  bool follow(FitPoint& point, const Eigen::VectorXd& shared_step) {
    const std::vector<Eigen::VectorXd> before = own_of(point);
    const double staying = cost_at(point);
    move(point, -(rest_ + response_ * shared_step));
    cost_ = cost_at(point);
    if (!(cost_ < staying)) {
      std::ranges::copy(before, point.own.begin() + static_cast<std::ptrdiff_t>(first()));
      cost_ = staying;
    }
    return cost_ < kInfinity && linearise(point);
  }

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

  bool evaluate(const FitPoint& point, bool with_derivatives) const {
    for (std::size_t k = first(); k < last(); ++k) {
      SegmentResidual& residual = (*residuals_)[k];
      const double* next = residual.segment().joined ? point.own[k + 1].data() : nullptr;
      if (!residual.evaluate(point.shared.data(), point.own[k].data(), next, with_derivatives)) return false;
    }
    return true;
  }

  static Eigen::VectorXd weights_of(const MotionEquations& equations) {
    Eigen::VectorXd weights = equations.dpsi;
    for (Eigen::Index row = 0; row < weights.size(); ++row) {
      const double size = std::abs(equations.residual[row]);
      const double secant = size > 0.0 ? std::abs(equations.psi[row]) / size : 1.0;
      weights[row] = std::max(weights[row], kWeightFloor * secant);
    }
    return weights;
  }

  void find_free(const FitPoint& point) {
    free_.clear();
    const int directions = problem_->own_chart.directions();
    for (std::size_t k = first(); k < last(); ++k) {
      const int begin = directions * static_cast<int>(k - first());
      add_free(problem_->own, problem_->own_chart, point.own[k], by_own_.segment(begin, directions), begin,
               free_);
    }
  }

  std::vector<Eigen::VectorXd> own_of(const FitPoint& point) const {
    return {point.own.begin() + static_cast<std::ptrdiff_t>(first()),
            point.own.begin() + static_cast<std::ptrdiff_t>(last())};
  }

  void move(FitPoint& point, const Eigen::VectorXd& step) const {
    const Eigen::Index directions = problem_->own_chart.directions();
    for (std::size_t k = first(); k < last(); ++k) {
      const auto part = step.segment(directions * static_cast<Eigen::Index>(k - first()), directions);
      point.own[k] = moved(problem_->own, problem_->own_chart, point.own[k], part);
    }
  }

  /// The step that was taken, which bounds may have cut.
  Eigen::VectorXd taken(const std::vector<Eigen::VectorXd>& before, const FitPoint& point) const {
    const Eigen::Index directions = problem_->own_chart.directions();
    Eigen::VectorXd step(directions * static_cast<Eigen::Index>(before.size()));
    for (std::size_t k = 0; k < before.size(); ++k) {
      step.segment(directions * static_cast<Eigen::Index>(k), directions) =
          step_between(problem_->own_chart, before[k], point.own[first() + k]);
    }
    return step;
  }

  /// @returns false if no damping lowers the cost
  bool step(FitPoint& point) {
    const std::vector<Eigen::VectorXd> before = own_of(point);
    const Eigen::VectorXd scale = damping_scale(own_.normal());
    while (damping_ < kMostDamping) {
      const Eigen::MatrixXd hessian = own_.hessian();
      const auto wanted = damped_step(hessian, scale, by_own_, free_, damping_);
      if (wanted) {
        move(point, *wanted);
        const double reached = cost_at(point);
        if (reached < cost_) {
          const Eigen::VectorXd step = taken(before, point);
          const double predicted = -(by_own_.dot(step) + 0.5 * step.dot(hessian * step));
          damping_ = after_success(damping_, predicted > 0.0 ? (cost_ - reached) / predicted : 1.0);
          cost_ = reached;
          const Eigen::VectorXd slope = by_own_;
          linearise(point);
          own_.learn(step, by_own_ - slope);
          return true;
        }
        std::ranges::copy(before, point.own.begin() + static_cast<std::ptrdiff_t>(first()));
      }
      if (own_.has_learned()) {
        own_.forget();
      } else {
        damping_ *= 8.0;
      }
    }
    damping_ = kFirstDamping;
    return false;
  }

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

class SeparableDescent {
 public:
  SeparableDescent(const FitProblem& problem, std::vector<SegmentResidual>& residuals, FitPoint start,
                   double share)
      : problem_(problem), point_(std::move(start)), share_(share) {
    for (const Motion& motion : problem.motions) motions_.emplace_back(problem, residuals, motion);
  }

  MinimizeResult run(int max_iterations) {
    each_motion([&](MotionDescent& motion) { motion.start_at(point_); });
    if (!std::isfinite(total()))
      return {.point = std::move(point_), .message = "there is no trajectory at this start"};
    MinimizeResult result{.status = FitStatus::iteration_limit};
    if (problem_.shared_chart.directions() > 0) {
      settle(kOwnSteps);
      while (result.status != FitStatus::converged && result.iterations < max_iterations) {
        ++result.iterations;
        if (step_is_last()) result.status = FitStatus::converged;
      }
    } else {
      settle_alone(max_iterations, result);
    }
    if (result.status == FitStatus::converged) polish();
    result.message = result.status == FitStatus::converged
                         ? "no step would move an unknown by a noticeable share of its error"
                         : "iterations were spent";
    result.cost = total();
    result.point = std::move(point_);
    return result;
  }

 private:
  template <class Action>
  void each_motion(const Action& action) {
    tbb::parallel_for(std::size_t{0}, motions_.size(), [&](std::size_t k) { action(motions_[k]); });
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
    if (all_settled()) result.status = FitStatus::converged;
  }

  /// One step more than the end asks for: where the cost is smooth, it is worth many.
  void polish() {
    if (problem_.shared_chart.directions() > 0) {
      reduce();
      const double cost = total();
      if (decrement(model_, gradient_, free_) > kRounding * cost) try_steps(cost);
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
    if (gain <= std::max(allowance(), kRounding * cost)) {
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
            damping_ = after_success(damping_, predicted > 0.0 ? (cost - reached) / predicted : 1.0);
            return true;
          }
        }
        point_ = before;
        motions_ = motions;
      }
      if (model_.has_learned()) {
        model_.forget();
      } else {
        damping_ *= 8.0;
      }
    }
    damping_ = kFirstDamping;
    return false;
  }

  bool follow_and_settle() {
    std::vector<char> ok(motions_.size(), 0);
    tbb::parallel_for(std::size_t{0}, motions_.size(),
                      [&](std::size_t k) { ok[k] = motions_[k].follow(point_, step_); });
    if (!std::ranges::all_of(ok, [](char one) { return one != 0; })) return false;
    settle(kOwnSteps);
    return true;
  }

  const FitProblem& problem_;
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
