#include "samara/identification/minimize.h"

#include <cmath>
#include <exception>
#include <memory>

#include <ceres/ceres.h>
#include <fmt/format.h>

#include "samara/identification/loss.h"

namespace samara::identification {

namespace {

/// The residuals of one segment for Ceres: sign(r) sqrt(rho(r)), so that half their squares sum to the cost,
/// frame by frame (a ceres::LossFunction would see all frames of a capture as one residual). The derivative
/// is psi/sqrt(rho) times that of r.
class SegmentCost final : public ceres::CostFunction {
 public:
  SegmentCost(const FitProblem& problem, SegmentResidual& residual)
      : loss_(problem.loss),
        shared_(problem.shared_count()),
        own_(problem.own_count()),
        residual_(&residual) {
    set_num_residuals(residual.size());
    if (shared_ > 0) mutable_parameter_block_sizes()->push_back(shared_);
    if (own_ > 0) mutable_parameter_block_sizes()->push_back(own_);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const std::size_t own_block = shared_ > 0 ? 1 : 0;
    try {
      const double* shared = shared_ > 0 ? parameters[0] : nullptr;
      const double* own = own_ > 0 ? parameters[own_block] : nullptr;
      if (!residual_->evaluate(shared, own, jacobians != nullptr)) return false;
    } catch (...) {
      thrown_ = std::current_exception();  // not through Ceres
      return false;
    }
    double* by_shared = jacobians && shared_ > 0 ? jacobians[0] : nullptr;
    double* by_own = jacobians && own_ > 0 ? jacobians[own_block] : nullptr;
    for (Eigen::Index row = 0; row < residual_->size(); ++row) {
      const double r = residual_->residual()[row];
      const LossValue value = loss_value(loss_, r);
      const double size = std::sqrt(value.rho);
      residuals[row] = std::copysign(size, r);
      const double factor = size > 0.0 ? std::abs(value.psi) / size : 1.0;
      if (by_shared) fill(by_shared, row, factor, residual_->by_shared());
      if (by_own) fill(by_own, row, factor, residual_->by_own());
    }
    return true;
  }

  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  /// Ceres' matrices are row by row.
  static void fill(double* jacobian, Eigen::Index row, double factor, const Eigen::MatrixXd& derivatives) {
    for (Eigen::Index k = 0; k < derivatives.cols(); ++k) {
      jacobian[row * derivatives.cols() + k] = factor * derivatives(row, k);
    }
  }

  LossKind loss_;
  int shared_;
  int own_;
  SegmentResidual* residual_;
  mutable std::exception_ptr thrown_;
};

void set_box(ceres::Problem& problem, double* block, const std::vector<FitCoordinate>& coordinates) {
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    problem.SetParameterLowerBound(block, static_cast<int>(k), coordinates[k].lower);
    problem.SetParameterUpperBound(block, static_cast<int>(k), coordinates[k].upper);
  }
}

/// All unknowns in one block of memory. Ceres orders parameter blocks by their addresses, and with the order
/// the rounding of its sums: separate blocks would give other bits in every run.
class Unknowns {
 public:
  Unknowns(const FitPoint& point, int shared, int own) : shared_(shared), own_(own) {
    values_.resize(shared + own * static_cast<Eigen::Index>(point.own.size()));
    values_.head(shared) = point.shared;
    for (std::size_t c = 0; c < point.own.size(); ++c) values_.segment(place(c), own) = point.own[c];
  }

  double* shared() { return values_.data(); }
  double* own(std::size_t segment) { return values_.data() + place(segment); }
  void store(FitPoint& point) const {
    point.shared = values_.head(shared_);
    for (std::size_t c = 0; c < point.own.size(); ++c) point.own[c] = values_.segment(place(c), own_);
  }

 private:
  Eigen::Index place(std::size_t segment) const {
    return shared_ + own_ * static_cast<Eigen::Index>(segment);
  }

  int shared_;
  int own_;
  Eigen::VectorXd values_;
};

ceres::Solver::Options solver_options(const FitProblem& problem, Unknowns& unknowns, int max_iterations) {
  ceres::Solver::Options options;
  options.max_num_iterations = max_iterations;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.minimizer_progress_to_stdout = false;
  // Where many residuals are outliers the steps converge linearly only. At a relative change of 1e-11 the
  // coefficients stand still within a thousandth of their standard errors.
  options.function_tolerance = 1e-11;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-11;
  const bool has_shared = problem.shared_count() > 0;
  const bool has_own = problem.own_count() > 0;
  if (!has_own) {
    options.linear_solver_type = ceres::DENSE_QR;
  } else if (!has_shared) {
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;  // one small block per capture
  } else {
    options.linear_solver_type = ceres::DENSE_SCHUR;
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (std::size_t c = 0; c < problem.segments.size(); ++c) ordering->AddElementToGroup(unknowns.own(c), 0);
    ordering->AddElementToGroup(unknowns.shared(), 1);
    options.linear_solver_ordering = ordering;
  }
  return options;
}

FitStatus status_of(const ceres::Solver::Summary& summary) {
  switch (summary.termination_type) {
    case ceres::CONVERGENCE:
    case ceres::USER_SUCCESS:
      return FitStatus::converged;
    case ceres::NO_CONVERGENCE:
      return FitStatus::iteration_limit;
    default:
      return FitStatus::failed;
  }
}

/// Whether there is a trajectory for every segment. Ceres would complain about a start without one on stderr.
bool can_start(std::vector<SegmentResidual>& residuals, Unknowns& unknowns) {
  for (std::size_t c = 0; c < residuals.size(); ++c) {
    if (!residuals[c].evaluate(unknowns.shared(), unknowns.own(c), false)) return false;
  }
  return true;
}

/// One residual block per segment, over the shared block and its own.
std::vector<std::unique_ptr<SegmentCost>> add_costs(const FitProblem& problem,
                                                    std::vector<SegmentResidual>& residuals,
                                                    Unknowns& unknowns, ceres::Problem& ceres_problem) {
  std::vector<std::unique_ptr<SegmentCost>> costs;
  for (std::size_t c = 0; c < residuals.size(); ++c) {
    costs.push_back(std::make_unique<SegmentCost>(problem, residuals[c]));
    std::vector<double*> blocks;
    if (problem.shared_count() > 0) blocks.push_back(unknowns.shared());
    if (problem.own_count() > 0) blocks.push_back(unknowns.own(c));
    ceres_problem.AddResidualBlock(costs.back().get(), nullptr, blocks);
    if (problem.own_count() > 0) set_box(ceres_problem, unknowns.own(c), problem.own);
  }
  if (problem.shared_count() > 0) set_box(ceres_problem, unknowns.shared(), problem.shared);
  return costs;
}

}  // namespace

MinimizeResult minimize(const FitProblem& problem, std::vector<SegmentResidual>& residuals, FitPoint start,
                        int max_iterations) {
  MinimizeResult result{.point = std::move(start), .message = "there is no trajectory at this start"};
  Unknowns unknowns(result.point, problem.shared_count(), problem.own_count());
  if (!can_start(residuals, unknowns)) return result;

  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem ceres_problem(ownership);
  const auto costs = add_costs(problem, residuals, unknowns, ceres_problem);
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(problem, unknowns, max_iterations), &ceres_problem, &summary);
  for (const auto& cost : costs) cost->rethrow();

  unknowns.store(result.point);
  result.status = status_of(summary);
  result.message = summary.message;
  result.cost = summary.final_cost;
  result.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
  return result;
}

}  // namespace samara::identification
