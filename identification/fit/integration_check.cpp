#include "samara/identification/fit/integration_check.h"

#include <cmath>

#include <fmt/format.h>

#include "samara/identification/solve/motion_terms.h"
#include "samara/identification/statistics/determined_inverse.h"

namespace samara::identification {

namespace {

/// Standard errors by which a coefficient may move without a warning.
constexpr double kTolerable = 0.1;

/// Gradient of the cost by the shared unknowns, the own ones eliminated.
Eigen::VectorXd reduced_gradient(const FitProblem& problem, const std::vector<SegmentResidual>& residuals,
                                 const FitPoint& point) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(problem.shared_count());
  const double slope = mean_slope(problem, residuals);
  for (const Motion& motion : problem.motions) {
    gradient +=
        motion_terms(problem, motion, residuals, point, slope, free_directions(problem, motion, point)).score;
  }
  return gradient;
}

/// Shared unknowns that have an error.
std::vector<int> movable(const Uncertainty& uncertainty) {
  std::vector<int> indices;
  for (std::size_t k = 0; k < uncertainty.at_bound.size(); ++k) {
    if (!uncertainty.at_bound[k] && uncertainty.determined[k]) indices.push_back(static_cast<int>(k));
  }
  return indices;
}

void warn(const Coefficient& worst, FitResult& result) {
  result.warnings.add(WarningKind::steps, fmt::format("the steps of the integration are too long: with half "
                                                      "of them {} would move by {:.2g} of its standard "
                                                      "errors, to {:.6g}; a shorter `step` is advised",
                                                      worst.name, *result.integration_shift,
                                                      worst.value + *worst.integration_shift));
}

}  // namespace

void add_integration_shift(const models::TrajectoryFamily& family, const FitProblem& problem,
                           const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                           const Uncertainty& uncertainty, FitResult& result) {
  const std::unique_ptr<models::TrajectoryFamily> finer = family.finer();
  const std::vector<int> free = movable(uncertainty);
  if (!finer || free.empty()) return;
  std::vector<SegmentResidual> halved = make_residuals(*finer, problem, residuals);
  if (!evaluate_all(halved, point)) {
    result.warnings.add(
        WarningKind::steps,
        "with steps of half the length there is no trajectory where the fit ended: a shorter `step` is "
        "advised");
    return;
  }
  const Eigen::VectorXd change =
      reduced_gradient(problem, residuals, point) - reduced_gradient(problem, halved, point);
  const DeterminedInverse inverse = invert_determined(
      uncertainty.information(free, free), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free.size())));
  const Eigen::VectorXd shift = inverse.inverse * change(free);
  const Coefficient* worst = nullptr;
  for (std::size_t k = 0; k < free.size(); ++k) {
    Coefficient& c = result.coefficients[static_cast<std::size_t>(free[k])];
    c.integration_shift = shift[static_cast<Eigen::Index>(k)];
    const double error = c.standard_error.value_or(c.naive_standard_error.value_or(0.0));
    if (!(error > 0.0)) continue;
    const double share = std::abs(*c.integration_shift) / error;
    if (worst != nullptr && share <= *result.integration_shift) continue;
    result.integration_shift = share;
    worst = &c;
  }
  if (worst != nullptr && *result.integration_shift > kTolerable) warn(*worst, result);
}

}  // namespace samara::identification
