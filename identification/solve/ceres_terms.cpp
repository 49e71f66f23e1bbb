#include "samara/identification/solve/ceres_terms.h"

#include <algorithm>
#include <cmath>

#include "samara/base/parallel.h"
#include "samara/identification/statistics/loss.h"

namespace samara::identification {

namespace {

using RowMajor = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

/// Ceres' matrices are row by row.
void fill(double* jacobian, Eigen::Index row, double factor, const Eigen::MatrixXd& derivatives) {
  for (Eigen::Index k = 0; k < derivatives.cols(); ++k) {
    jacobian[row * derivatives.cols() + k] = factor * derivatives(row, k);
  }
}

}  // namespace

Unknowns::Unknowns(const FitPoint& point, int shared, int own) : shared_(shared), own_(own) {
  values_.resize(shared + own * static_cast<Eigen::Index>(point.own.size()));
  values_.head(shared) = point.shared;
  for (std::size_t c = 0; c < point.own.size(); ++c) values_.segment(place(c), own) = point.own[c];
}

void Unknowns::store(FitPoint& point) const {
  point.shared = values_.head(shared_);
  for (std::size_t c = 0; c < point.own.size(); ++c) point.own[c] = values_.segment(place(c), own_);
}

void Evaluation::evaluate(bool with_derivatives) {
  if (point_ == unknowns_.values() && (has_derivatives_ || !with_derivatives)) return;
  point_ = unknowns_.values();
  has_derivatives_ = with_derivatives;
  try {
    parallel_for(residuals_.size(), [&](std::size_t k) {
      const double* next = residuals_[k].segment().joined ? unknowns_.own(k + 1) : nullptr;
      is_finite_[k] = residuals_[k].evaluate(unknowns_.shared(), unknowns_.own(k), next, with_derivatives);
    });
  } catch (...) {
    thrown_ = std::current_exception();
    point_.reset();
    std::ranges::fill(is_finite_, 0);
  }
}

bool Evaluation::all_are_finite() {
  evaluate(true);
  rethrow();
  return std::ranges::all_of(is_finite_, [](char one) { return one != 0; });
}

SegmentCost::SegmentCost(const FitProblem& problem, const SegmentResidual& residual,
                         const Evaluation& evaluation, std::size_t number)
    : loss_(problem.loss),
      root_weight_(std::sqrt(problem.motion_of(residual.segment()).weight)),
      residual_(residual),
      evaluation_(evaluation),
      number_(number) {
  set_num_residuals(residual.size());
  if (problem.shared_count() > 0) add_block(problem.shared_count(), residual.by_shared());
  if (problem.own_count() > 0) add_block(problem.own_count(), residual.by_own());
  if (residual.segment().joined) add_block(problem.own_count(), residual.by_next());
}

void SegmentCost::add_block(int size, const Eigen::MatrixXd& derivatives) {
  mutable_parameter_block_sizes()->push_back(size);
  blocks_.push_back(&derivatives);
}

bool SegmentCost::Evaluate(double const* const* /*parameters*/, double* residuals, double** jacobians) const {
  if (!evaluation_.is_finite_at(number_)) return false;
  for (Eigen::Index row = 0; row < residual_.size(); ++row) {
    const double r = residual_.residual()[row];
    double factor = root_weight_;
    residuals[row] = root_weight_ * r;
    if (row < residual_.data_size()) {
      const LossValue value = loss_value(loss_, r);
      const double size = std::sqrt(value.rho);
      residuals[row] = root_weight_ * std::copysign(size, r);
      if (size > 0.0) factor *= std::abs(value.psi) / size;
    }
    for (std::size_t block = 0; jacobians && block < blocks_.size(); ++block) {
      if (jacobians[block]) fill(jacobians[block], row, factor, *blocks_[block]);
    }
  }
  return true;
}

PriorCost::PriorCost(const FitProblem& problem) : priors_(problem.priors) {
  set_num_residuals(static_cast<int>(priors_.size()));
  mutable_parameter_block_sizes()->push_back(problem.shared_count());
}

bool PriorCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const int shared = parameter_block_sizes()[0];
  const bool with_derivatives = jacobians && jacobians[0];
  if (with_derivatives) std::fill_n(jacobians[0], num_residuals() * shared, 0.0);
  for (int row = 0; row < num_residuals(); ++row) {
    const PriorTerm& prior = priors_[static_cast<std::size_t>(row)];
    residuals[row] = prior.residual(parameters[0]);
    if (!with_derivatives) continue;
    for (const auto& [unknown, weight] : prior.weights()) {
      jacobians[0][row * shared + unknown] = weight * prior.slope(parameters[0]);
    }
  }
  return true;
}

bool ChartManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  chart_.plus(x, delta, x_plus_delta);
  return true;
}

bool ChartManifold::PlusJacobian(const double* x, double* jacobian) const {
  RowMajor(jacobian, chart_.size(), chart_.directions()) = chart_.plus_jacobian(x);
  return true;
}

bool ChartManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  chart_.minus(y, x, y_minus_x);
  return true;
}

bool ChartManifold::MinusJacobian(const double* x, double* jacobian) const {
  RowMajor(jacobian, chart_.directions(), chart_.size()) = chart_.minus_jacobian(x);
  return true;
}

}  // namespace samara::identification
