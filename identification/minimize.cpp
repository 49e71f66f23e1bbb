#include "samara/identification/minimize.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include <ceres/ceres.h>
#include <tbb/parallel_for.h>

#include "samara/identification/loss.h"

namespace samara::identification {

namespace {

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

/// All segments at one point, each by one thread at a time, before Ceres asks for them one by one.
class Evaluation final : public ceres::EvaluationCallback {
 public:
  Evaluation(std::vector<SegmentResidual>& residuals, Unknowns& unknowns)
      : residuals_(residuals), unknowns_(unknowns), ok_(residuals.size(), 0) {}

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_point) override {
    if (!new_point && (has_jacobians_ || !evaluate_jacobians)) return;
    has_jacobians_ = evaluate_jacobians;
    try {
      tbb::parallel_for(std::size_t{0}, residuals_.size(), [&](std::size_t k) {
        const double* next = residuals_[k].segment().joined ? unknowns_.own(k + 1) : nullptr;
        ok_[k] = residuals_[k].evaluate(unknowns_.shared(), unknowns_.own(k), next, evaluate_jacobians);
      });
    } catch (...) {
      thrown_ = std::current_exception();  // not through Ceres
      std::ranges::fill(ok_, 0);
    }
  }

  bool has_trajectory(std::size_t segment) const { return ok_[segment] != 0; }
  bool all_have_trajectories() {
    PrepareForEvaluation(false, true);
    rethrow();
    return std::ranges::all_of(ok_, [](char ok) { return ok != 0; });
  }
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  std::vector<SegmentResidual>& residuals_;
  Unknowns& unknowns_;
  std::vector<char> ok_;
  bool has_jacobians_ = false;
  std::exception_ptr thrown_;
};

/// The residuals of one segment for Ceres: sign(r) sqrt(rho(r)), so that half their squares sum to the cost,
/// frame by frame (a ceres::LossFunction would see all frames of a capture as one residual). The derivative
/// is psi/sqrt(rho) times that of r. Joins have no loss.
class SegmentCost final : public ceres::CostFunction {
 public:
  SegmentCost(const FitProblem& problem, const SegmentResidual& residual, const Evaluation& evaluation,
              std::size_t number)
      : loss_(problem.loss), residual_(residual), evaluation_(evaluation), number_(number) {
    set_num_residuals(residual.size());
    if (problem.shared_count() > 0) add_block(problem.shared_count(), residual.by_shared());
    if (problem.own_count() > 0) add_block(problem.own_count(), residual.by_own());
    if (residual.segment().joined) add_block(problem.own_count(), residual.by_next());
  }

  bool Evaluate(double const* const* /*parameters*/, double* residuals, double** jacobians) const override {
    if (!evaluation_.has_trajectory(number_)) return false;
    for (Eigen::Index row = 0; row < residual_.size(); ++row) {
      const double r = residual_.residual()[row];
      double factor = 1.0;
      residuals[row] = r;
      if (row < residual_.data_size()) {
        const LossValue value = loss_value(loss_, r);
        const double size = std::sqrt(value.rho);
        residuals[row] = std::copysign(size, r);
        if (size > 0.0) factor = std::abs(value.psi) / size;
      }
      for (std::size_t block = 0; jacobians && block < blocks_.size(); ++block) {
        if (jacobians[block]) fill(jacobians[block], row, factor, *blocks_[block]);
      }
    }
    return true;
  }

 private:
  void add_block(int size, const Eigen::MatrixXd& derivatives) {
    mutable_parameter_block_sizes()->push_back(size);
    blocks_.push_back(&derivatives);
  }

  /// Ceres' matrices are row by row.
  static void fill(double* jacobian, Eigen::Index row, double factor, const Eigen::MatrixXd& derivatives) {
    for (Eigen::Index k = 0; k < derivatives.cols(); ++k) {
      jacobian[row * derivatives.cols() + k] = factor * derivatives(row, k);
    }
  }

  LossKind loss_;
  const SegmentResidual& residual_;
  const Evaluation& evaluation_;
  std::size_t number_;
  std::vector<const Eigen::MatrixXd*> blocks_;
};

/// What was known of the shared unknowns beforehand.
class PriorCost final : public ceres::CostFunction {
 public:
  explicit PriorCost(const FitProblem& problem)
      : priors_(problem.priors), combinations_(problem.combinations) {
    set_num_residuals(static_cast<int>(priors_.size() + combinations_.size()));
    mutable_parameter_block_sizes()->push_back(problem.shared_count());
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const int shared = parameter_block_sizes()[0];
    if (jacobians && jacobians[0]) std::fill_n(jacobians[0], num_residuals() * shared, 0.0);
    for (std::size_t k = 0; k < priors_.size(); ++k) {
      const PriorResidual prior = prior_residual(priors_[k].prior, parameters[0][priors_[k].shared]);
      residuals[k] = prior.value;
      if (jacobians && jacobians[0]) {
        jacobians[0][static_cast<int>(k) * shared + priors_[k].shared] = prior.derivative;
      }
    }
    for (std::size_t k = 0; k < combinations_.size(); ++k) {
      const auto row = static_cast<int>(priors_.size() + k);
      residuals[row] = combinations_[k].residual(parameters[0]);
      for (const auto& [index, weight] : combinations_[k].terms) {
        if (jacobians && jacobians[0])
          jacobians[0][row * shared + index] = weight / combinations_[k].deviation;
      }
    }
    return true;
  }

 private:
  std::vector<SharedPrior> priors_;
  std::vector<SharedCombination> combinations_;
};

/// A chart as Ceres takes it.
class ChartManifold final : public ceres::Manifold {
 public:
  explicit ChartManifold(const Chart& chart) : chart_(chart) {}

  int AmbientSize() const override { return chart_.size(); }
  int TangentSize() const override { return chart_.directions(); }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    chart_.plus(x, delta, x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    RowMajor(jacobian, chart_.size(), chart_.directions()) = chart_.plus_jacobian(x);
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    chart_.minus(y, x, y_minus_x);
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    RowMajor(jacobian, chart_.directions(), chart_.size()) = chart_.minus_jacobian(x);
    return true;
  }

 private:
  using RowMajor = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  const Chart& chart_;
};

/// Bounds; not of what a quaternion consists of, which moves on the sphere.
void set_box(ceres::Problem& problem, double* block, const std::vector<FitCoordinate>& coordinates,
             const Chart& chart) {
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    if (chart.is_part_of_quaternion(static_cast<int>(k))) continue;
    problem.SetParameterLowerBound(block, static_cast<int>(k), coordinates[k].lower);
    problem.SetParameterUpperBound(block, static_cast<int>(k), coordinates[k].upper);
  }
}

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
  const bool has_shared = problem.shared_chart.directions() > 0;
  const bool has_own = problem.own_count() > 0;
  if (!has_own) {
    options.linear_solver_type = ceres::DENSE_QR;
  } else if (!has_shared || problem.is_joined()) {
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;  // small blocks, chained or not
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

/// The parts of a problem that Ceres refers to.
struct Costs {
  std::vector<std::unique_ptr<ceres::CostFunction>> functions;
  ChartManifold shared, own;
};

void add_costs(const FitProblem& problem, const std::vector<SegmentResidual>& residuals,
               const Evaluation& evaluation, Unknowns& unknowns, Costs& costs,
               ceres::Problem& ceres_problem) {
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    costs.functions.push_back(std::make_unique<SegmentCost>(problem, residuals[k], evaluation, k));
    std::vector<double*> blocks;
    if (problem.shared_count() > 0) blocks.push_back(unknowns.shared());
    if (problem.own_count() > 0) blocks.push_back(unknowns.own(k));
    if (residuals[k].segment().joined) blocks.push_back(unknowns.own(k + 1));
    ceres_problem.AddResidualBlock(costs.functions.back().get(), nullptr, blocks);
  }
  if (!problem.priors.empty() || !problem.combinations.empty()) {
    costs.functions.push_back(std::make_unique<PriorCost>(problem));
    ceres_problem.AddResidualBlock(costs.functions.back().get(), nullptr, unknowns.shared());
  }
  if (problem.shared_count() > 0) {
    set_box(ceres_problem, unknowns.shared(), problem.shared, problem.shared_chart);
    if (!problem.shared_chart.is_linear()) ceres_problem.SetManifold(unknowns.shared(), &costs.shared);
  }
  for (std::size_t k = 0; problem.own_count() > 0 && k < residuals.size(); ++k) {
    set_box(ceres_problem, unknowns.own(k), problem.own, problem.own_chart);
    if (!problem.own_chart.is_linear()) ceres_problem.SetManifold(unknowns.own(k), &costs.own);
  }
}

}  // namespace

MinimizeResult minimize(const FitProblem& problem, std::vector<SegmentResidual>& residuals, FitPoint start,
                        int max_iterations) {
  MinimizeResult result{.point = std::move(start), .message = "there is no trajectory at this start"};
  Unknowns unknowns(result.point, problem.shared_count(), problem.own_count());
  Evaluation evaluation(residuals, unknowns);
  // Ceres would complain about a start without trajectories on stderr.
  if (!evaluation.all_have_trajectories()) return result;

  Costs costs{{}, ChartManifold(problem.shared_chart), ChartManifold(problem.own_chart)};
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.evaluation_callback = &evaluation;
  ceres::Problem ceres_problem(ownership);
  add_costs(problem, residuals, evaluation, unknowns, costs, ceres_problem);
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(problem, unknowns, max_iterations), &ceres_problem, &summary);
  evaluation.rethrow();

  unknowns.store(result.point);
  result.status = status_of(summary);
  result.message = summary.message;
  result.cost = summary.final_cost;
  result.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
  return result;
}

}  // namespace samara::identification
