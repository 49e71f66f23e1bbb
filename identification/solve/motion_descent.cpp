#include "samara/identification/solve/motion_descent.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "samara/identification/statistics/loss.h"

namespace samara::identification {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Beside the Hessian of the loss, of what least squares with weights psi/r have: outliers must not leave a
/// direction without curvature.
constexpr double kWeightFloor = 0.2;
/// Own unknowns are settled beyond what is asked of the end, from the first step on: what they leave is noise
/// in the slopes from which the shared ones learn. Of the allowance.
constexpr double kOwnShare = 0.01;

}  // namespace

double MotionDescent::cost_at(const FitPoint& point) const {
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

bool MotionDescent::linearise(const FitPoint& point) {
  if (!evaluate(point, true)) return false;
  const MotionEquations equations = motion_equations(*problem_, *motion_, *residuals_, point);
  const Eigen::MatrixXd J_s = equations.by_shared * problem_->shared_chart.plus_jacobian(point.shared.data());
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

void MotionDescent::start_at(const FitPoint& point) {
  cost_ = cost_at(point);
  if (cost_ < kInfinity && !linearise(point)) cost_ = kInfinity;
}

void MotionDescent::settle(FitPoint& point, int most_steps, double allowance) {
  for (steps_ = 0;; ++steps_) {
    const double gain = decrement(own_, by_own_, free_);
    settled_ = gain <= std::max(allowance, kCostRounding * cost_);
    if (gain <= std::max(kOwnShare * allowance, kCostRounding * cost_) || steps_ == most_steps) return;
    if (!step(point)) {
      settled_ = true;  // nothing lowers the cost
      return;
    }
  }
}

void MotionDescent::polish(FitPoint& point) {
  if (decrement(own_, by_own_, free_) > kCostRounding * cost_) step(point);
}

void MotionDescent::eliminate() {
  const FreeInverse inverse(own_.hessian(), own_.normal(), free_);
  response_ = inverse.times(cross_);
  rest_ = inverse.times(by_own_);
  reduced_gradient_ = by_shared_ - cross_.transpose() * rest_;
  const FreeInverse normal(own_.normal(), own_.normal(), free_);
  reduced_normal_ = shared_normal_ - cross_.transpose() * normal.times(cross_);
}

bool MotionDescent::follow(FitPoint& point, const Eigen::VectorXd& shared_step) {
  const std::vector<Eigen::VectorXd> before = own_of(point);
  const double staying = cost_at(point);
  move(point, -(rest_ + response_ * shared_step));
  cost_ = cost_at(point);
  if (cost_ < staying && linearise(point)) return true;
  std::ranges::copy(before, point.own.begin() + static_cast<std::ptrdiff_t>(first()));
  cost_ = staying;
  return cost_ < kInfinity && linearise(point);
}

bool MotionDescent::evaluate(const FitPoint& point, bool with_derivatives) const {
  for (std::size_t k = first(); k < last(); ++k) {
    SegmentResidual& residual = (*residuals_)[k];
    const double* next = residual.segment().joined ? point.own[k + 1].data() : nullptr;
    if (!residual.evaluate(point.shared.data(), point.own[k].data(), next, with_derivatives)) return false;
  }
  return true;
}

Eigen::VectorXd MotionDescent::weights_of(const MotionEquations& equations) {
  Eigen::VectorXd weights = equations.dpsi;
  for (Eigen::Index row = 0; row < weights.size(); ++row) {
    const double size = std::abs(equations.residual[row]);
    const double secant = size > 0.0 ? std::abs(equations.psi[row]) / size : 1.0;
    weights[row] = std::max(weights[row], kWeightFloor * secant);
  }
  return weights;
}

void MotionDescent::find_free(const FitPoint& point) {
  free_.clear();
  const int directions = problem_->own_chart.directions();
  for (std::size_t k = first(); k < last(); ++k) {
    const int begin = directions * static_cast<int>(k - first());
    add_free(problem_->own, problem_->own_chart, point.own[k], by_own_.segment(begin, directions), begin,
             free_);
  }
}

std::vector<Eigen::VectorXd> MotionDescent::own_of(const FitPoint& point) const {
  return {point.own.begin() + static_cast<std::ptrdiff_t>(first()),
          point.own.begin() + static_cast<std::ptrdiff_t>(last())};
}

void MotionDescent::move(FitPoint& point, const Eigen::VectorXd& step) const {
  const Eigen::Index directions = problem_->own_chart.directions();
  for (std::size_t k = first(); k < last(); ++k) {
    const auto part = step.segment(directions * static_cast<Eigen::Index>(k - first()), directions);
    point.own[k] = moved(problem_->own, problem_->own_chart, point.own[k], part);
  }
}

Eigen::VectorXd MotionDescent::taken(const std::vector<Eigen::VectorXd>& before,
                                     const FitPoint& point) const {
  const Eigen::Index directions = problem_->own_chart.directions();
  Eigen::VectorXd step(directions * static_cast<Eigen::Index>(before.size()));
  for (std::size_t k = 0; k < before.size(); ++k) {
    step.segment(directions * static_cast<Eigen::Index>(k), directions) =
        step_between(problem_->own_chart, before[k], point.own[first() + k]);
  }
  return step;
}

bool MotionDescent::step(FitPoint& point) {
  const std::vector<Eigen::VectorXd> before = own_of(point);
  const Eigen::VectorXd slope = by_own_;
  const Eigen::VectorXd scale = damping_scale(own_.normal());
  while (damping_ < kMostDamping) {
    const Eigen::MatrixXd hessian = own_.hessian();
    const auto wanted = damped_step(hessian, scale, slope, free_, damping_);
    if (wanted) {
      move(point, *wanted);
      const double reached = cost_at(point);
      if (reached < cost_ && linearise(point)) {
        const Eigen::VectorXd way = taken(before, point);
        const double predicted = -(slope.dot(way) + 0.5 * way.dot(hessian * way));
        damping_ = damping_after(damping_, predicted > 0.0 ? (cost_ - reached) / predicted : 1.0);
        cost_ = reached;
        own_.learn(way, by_own_ - slope);
        return true;
      }
      std::ranges::copy(before, point.own.begin() + static_cast<std::ptrdiff_t>(first()));
    }
    harden(own_, damping_);
  }
  damping_ = kFirstDamping;
  return false;
}

}  // namespace samara::identification
