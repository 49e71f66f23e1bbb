#include "samara/identification/solve/other_optima.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/base/names.h"
#include "samara/identification/solve/motion_terms.h"
#include "samara/identification/solve/uncertainty.h"
#include "samara/identification/statistics/loss.h"
#include "samara/identification/statistics/quantiles.h"

namespace samara::identification {

namespace {

constexpr double kConfidence = 0.95;
/// Values nearer than this share of a standard error are one value.
constexpr double kSameShare = 0.5;
/// The same without an error: of the box.
constexpr double kSameBoxShare = 0.01;

/// The part of the cost of each cluster.
/// @returns nothing without a trajectory
std::optional<Eigen::VectorXd> cluster_costs(const FitProblem& problem,
                                             std::vector<SegmentResidual>& residuals, const FitPoint& point) {
  if (!evaluate_all(residuals, point)) return {};
  Eigen::VectorXd costs = Eigen::VectorXd::Zero(problem.cluster_count);
  for (const SegmentResidual& residual : residuals) {
    double sum = 0.0;
    for (Eigen::Index row = 0; row < residual.size(); ++row) {
      const double r = residual.residual()[row];
      sum += row < residual.data_size() ? loss_value(problem.loss, r).rho : r * r;
    }
    costs[problem.motion_of(residual.segment()).cluster] += 0.5 * sum;
  }
  return costs;
}

double error_of(const Coefficient& c) {
  return c.standard_error.value_or(c.naive_standard_error.value_or(0.0));
}

bool same_value(const Coefficient& c, double one, double other) {
  const double error = error_of(c);
  const double margin = error > 0.0 ? kSameShare * error : kSameBoxShare * (c.upper - c.lower);
  return std::abs(one - other) <= margin;
}

bool same_optimum(const FitResult& result, const FitPoint& one, const FitPoint& other) {
  for (std::size_t k = 0; k < result.coefficients.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    if (!same_value(result.coefficients[k], one.shared[at], other.shared[at])) return false;
  }
  return true;
}

/// The standard error of the sum of differences of costs between clusters; NaN where there is but one.
double error_of_sum(const Eigen::ArrayXd& differences) {
  const auto clusters = static_cast<double>(differences.size());
  if (clusters < 2.0) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(clusters / (clusters - 1.0) * (differences - differences.mean()).square().sum());
}

/// The excess of a cost below which it is as good as the best one.
///
/// Where one cluster carries the excess, the scatter is as large as the excess, however hopeless the other optimum is.
/// So an excess beyond what chance allows among frames must also be small beside the scatter of the clusters that
/// prefer the other optimum: where there is no difference, half of the scatter is theirs.
/// @param differences of the costs, by cluster
double threshold(const Eigen::ArrayXd& differences, double dispersion) {
  const double by_chance = 0.5 * dispersion * chi_squared_quantile(1, kConfidence);
  const auto clusters = static_cast<double>(differences.size());
  if (clusters < 2.0) return by_chance;
  const double quantile = student_quantile(clusters - 1.0, kConfidence);
  const double of_preferring =
      std::sqrt(2.0 * clusters / (clusters - 1.0) * differences.cwiseMin(0.0).square().sum());
  return std::min(quantile * error_of_sum(differences), std::max(by_chance, quantile * of_preferring));
}

std::string values_text(const FitResult& result, const OtherOptimum& optimum) {
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < result.coefficients.size(); ++k) {
    const Coefficient& c = result.coefficients[k];
    if (same_value(c, c.value, optimum.coefficients[k])) continue;
    texts.push_back(fmt::format("{} = {:.5g} instead of {:.5g}", c.name, optimum.coefficients[k], c.value));
  }
  return join(texts);
}

}  // namespace

void add_other_optima(const FitProblem& problem, std::vector<SegmentResidual>& residuals,
                      const std::vector<MinimizeResult>& runs, std::size_t best, FitResult& result) {
  const FitPoint& answer = runs[best].point;
  const std::optional<Eigen::VectorXd> least = cluster_costs(problem, residuals, answer);
  if (!least || result.coefficients.empty() || result.status == Termination::not_determined) return;
  const double dispersion = estimate_uncertainty(problem, residuals, answer).dispersion;
  std::vector<const FitPoint*> known = {&answer};
  for (const MinimizeResult& run : runs) {
    if (run.status == Termination::failed) continue;
    if (std::ranges::any_of(known, [&](const FitPoint* p) { return same_optimum(result, *p, run.point); }))
      continue;
    known.push_back(&run.point);
    const std::optional<Eigen::VectorXd> costs = cluster_costs(problem, residuals, run.point);
    if (!costs) continue;
    const Eigen::ArrayXd differences = (*costs - *least).array();
    const double excess_error = error_of_sum(differences);
    OtherOptimum optimum{.coefficients = {run.point.shared.begin(), run.point.shared.end()},
                         .cost = run.cost,
                         .excess = run.cost - result.cost,
                         .excess_error = excess_error};
    if (!(optimum.excess < threshold(differences, dispersion))) continue;
    const Uncertainty uncertainty = estimate_uncertainty(problem, residuals, run.point);
    const Eigen::MatrixXd& covariance =
        problem.cluster_count >= 2 ? uncertainty.clustered : uncertainty.naive;
    for (Eigen::Index k = 0; k < covariance.rows(); ++k)
      optimum.standard_errors.push_back(std::sqrt(covariance(k, k)));
    result.warnings.add(
        WarningKind::optima,
        fmt::format("the captures do not distinguish the answer from another optimum, {}, whose cost is "
                    "higher by {:.3g}{}",
                    values_text(result, optimum), optimum.excess,
                    problem.cluster_count < 2 ? std::string()
                                              : fmt::format(" +- {:.3g} between clusters", excess_error)));
    result.other_optima.push_back(std::move(optimum));
  }
  if (runs.size() == 1 && !result.global_search) {
    result.warnings.add(WarningKind::optima,
                        "one start cannot tell whether there is another optimum: more are advised");
  }
}

}  // namespace samara::identification
