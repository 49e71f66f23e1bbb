#include "samara/identification/bootstrap.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/identification/minimize.h"
#include "samara/pgd/random.h"

namespace samara::identification {

namespace {

/// Of the cost. A standard error changes it by one half or more among thousands of residuals: steps that
/// change it by less than this are small beside errors that are themselves known to ten per cent.
constexpr double kTolerance = 1e-7;

/// One of each cluster; their mean is 1.
Eigen::ArrayXd random_weights(int clusters, pgd::Random& random) {
  Eigen::ArrayXd weights(clusters);
  for (double& weight : weights) weight = -std::log(1.0 - random.uniform());
  return weights / weights.mean();
}

/// Of each column.
std::vector<double> deviations(const Eigen::MatrixXd& values) {
  std::vector<double> result;
  for (Eigen::Index k = 0; k < values.cols(); ++k) {
    const Eigen::ArrayXd column = values.col(k);
    const auto degrees = static_cast<double>(column.size() - 1);
    result.push_back(degrees > 0.0 ? std::sqrt((column - column.mean()).square().sum() / degrees)
                                   : std::numeric_limits<double>::quiet_NaN());
  }
  return result;
}

}  // namespace

void add_bootstrap(const FitProblem& problem, std::vector<SegmentResidual>& residuals, const FitPoint& point,
                   const FitOptions& options, FitResult& result) {
  if (options.bootstrap.replicates < 1 || problem.cluster_count < 2 || problem.shared_count() == 0) return;
  FitProblem weighted = problem;
  Bootstrap bootstrap{.seed = options.bootstrap.seed};
  bootstrap.coefficients.resize(options.bootstrap.replicates, problem.shared_count());
  pgd::Random random(options.bootstrap.seed);
  for (int replicate = 0; replicate < options.bootstrap.replicates; ++replicate) {
    const Eigen::ArrayXd weights = random_weights(problem.cluster_count, random);
    for (Motion& motion : weighted.motions) motion.weight = weights[motion.cluster];
    const MinimizeResult run = minimize(weighted, residuals, point, options.max_iterations, kTolerance);
    if (run.status == FitStatus::failed) continue;
    bootstrap.converged += run.status == FitStatus::converged ? 1 : 0;
    bootstrap.coefficients.row(bootstrap.replicates++) = run.point.shared.transpose();
  }
  bootstrap.coefficients.conservativeResize(bootstrap.replicates, Eigen::NoChange);
  const double C = problem.cluster_count;
  for (const double deviation : deviations(bootstrap.coefficients)) {
    bootstrap.standard_errors.push_back(std::sqrt((C + 1.0) / (C - 1.0)) * deviation);
  }
  if (bootstrap.converged < bootstrap.replicates) {
    result.warnings.push_back(fmt::format(
        "{} of {} fits with clusters weighted at random did not converge within {} iterations: the "
        "errors from their scatter may be much too small",
        bootstrap.replicates - bootstrap.converged, bootstrap.replicates, options.max_iterations));
  }
  result.bootstrap = std::move(bootstrap);
}

}  // namespace samara::identification
