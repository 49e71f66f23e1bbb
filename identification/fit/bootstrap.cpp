#include "samara/identification/fit/bootstrap.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/identification/solve/minimize.h"
#include "samara/pgd/tensors/random.h"

namespace samara::identification {

namespace {

/// One of each cluster; their mean is 1.
Eigen::ArrayXd random_weights(int clusters, pgd::Random& random) {
  Eigen::ArrayXd weights(clusters);
  for (double& weight : weights) weight = -std::log(1.0 - random.uniform());
  return weights / weights.mean();
}

/// By which the scatter of replicates falls short of standard errors.
double widening(double clusters) {
  return std::sqrt((clusters + 1.0) / (clusters - 1.0));
}

/// Puts the means of priors where another repetition might have had them. Their errors are not widened by a
/// small number of clusters, as the scatter of all replicates will be.
void draw_priors(const FitProblem& problem, pgd::Random& random, FitProblem& drawn) {
  const double share = 1.0 / widening(problem.cluster_count);
  for (std::size_t k = 0; k < problem.priors.size(); ++k) {
    drawn.priors[k] = problem.priors[k].moved(share * random.normal());
  }
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
  if (options.uncertainty.bootstrap.replicates < 1 || problem.shared_count() == 0) return;
  if (problem.cluster_count < 2) {
    result.warnings.add(
        WarningKind::errors,
        "the captures are one cluster, so there are no errors from clusters weighted at random: a bootstrap "
        "needs two or more");
    return;
  }
  FitProblem weighted = problem;
  Bootstrap bootstrap{.seed = options.uncertainty.bootstrap.seed};
  bootstrap.coefficients.resize(options.uncertainty.bootstrap.replicates, problem.shared_count());
  pgd::Random random(options.uncertainty.bootstrap.seed);
  for (int replicate = 0; replicate < options.uncertainty.bootstrap.replicates; ++replicate) {
    const Eigen::ArrayXd weights = random_weights(problem.cluster_count, random);
    for (Motion& motion : weighted.motions) motion.weight = weights[motion.cluster];
    draw_priors(problem, random, weighted);
    // Their scatter is known to ten per cent at best.
    const MinimizeResult run =
        minimize(weighted, residuals, point, options.solver.max_iterations, Precision::rough);
    if (run.status == FitStatus::failed) continue;
    bootstrap.converged += run.status == FitStatus::converged ? 1 : 0;
    bootstrap.coefficients.row(bootstrap.replicates++) = run.point.shared.transpose();
  }
  bootstrap.coefficients.conservativeResize(bootstrap.replicates, Eigen::NoChange);
  for (const double deviation : deviations(bootstrap.coefficients)) {
    const bool is_held = result.coefficients[bootstrap.standard_errors.size()].at_bound;
    bootstrap.standard_errors.push_back(is_held ? std::numeric_limits<double>::quiet_NaN()
                                                : widening(problem.cluster_count) * deviation);
  }
  if (bootstrap.converged < bootstrap.replicates) {
    result.warnings.add(
        WarningKind::errors,
        fmt::format(
            "{} of {} fits with clusters weighted at random did not converge within {} iterations: the "
            "errors from their scatter may be much too small",
            bootstrap.replicates - bootstrap.converged, bootstrap.replicates, options.solver.max_iterations));
  }
  result.bootstrap = std::move(bootstrap);
}

}  // namespace samara::identification
