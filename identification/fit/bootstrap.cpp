#include "samara/identification/fit/bootstrap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include <fmt/format.h>

#include "samara/base/parallel.h"
#include "samara/base/streams.h"
#include "samara/identification/solve/minimize.h"

namespace samara::identification {

namespace {

/// One of each cluster; their mean is 1.
Eigen::ArrayXd random_weights(int clusters, Stream& random) {
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
void draw_priors(const FitProblem& problem, Stream& random, FitProblem& drawn) {
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

/// Fits that share the trajectories of one family: what is made for them once costs a fit or two.
constexpr int kGroup = 16;

/// The fits of a group, each from the answer, with weights and priors of its own stream.
class Replicates {
 public:
  Replicates(const models::TrajectoryFamily& family, const FitProblem& problem,
             const std::vector<SegmentResidual>& residuals, const FitPoint& point, const FitOptions& options)
      : options_(options),
        problem_(problem),
        weighted_(problem),
        point_(point),
        residuals_(make_residuals(family, problem, residuals)) {}

  MinimizeResult operator()(int replicate) {
    Stream random(options_.uncertainty.bootstrap.seed, static_cast<std::uint64_t>(replicate));
    const Eigen::ArrayXd weights = random_weights(problem_.cluster_count, random);
    for (Motion& motion : weighted_.motions) motion.weight = weights[motion.cluster];
    draw_priors(problem_, random, weighted_);
    // Their scatter is known to ten per cent at best.
    return minimize(weighted_, residuals_, point_, options_.solver.max_iterations, Precision::rough);
  }

  long evaluations() const { return evaluations_of(residuals_); }

 private:
  const FitOptions& options_;
  const FitProblem& problem_;
  FitProblem weighted_;
  const FitPoint& point_;
  std::vector<SegmentResidual> residuals_;
};

}  // namespace

void add_bootstrap(const models::TrajectoryFamily& family, const FitProblem& problem,
                   const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                   const FitOptions& options, FitResult& result) {
  const int replicates = options.uncertainty.bootstrap.replicates;
  if (replicates < 1 || problem.shared_count() == 0) return;
  if (problem.cluster_count < 2) {
    result.warnings.add(
        WarningKind::errors,
        "the captures are one cluster, so there are no errors from clusters weighted at random: a bootstrap "
        "needs two or more");
    return;
  }
  std::vector<MinimizeResult> runs(static_cast<std::size_t>(replicates));
  const int groups = (replicates + kGroup - 1) / kGroup;
  std::vector<long> evaluations(static_cast<std::size_t>(groups));
  parallel_for(groups, [&](int group) {
    Replicates fits(family, problem, residuals, point, options);
    for (int k = group * kGroup; k < std::min(replicates, (group + 1) * kGroup); ++k)
      runs[static_cast<std::size_t>(k)] = fits(k);
    evaluations[static_cast<std::size_t>(group)] = fits.evaluations();
  });
  result.evaluations += std::accumulate(evaluations.begin(), evaluations.end(), 0L);
  Bootstrap bootstrap{.seed = options.uncertainty.bootstrap.seed};
  bootstrap.coefficients.resize(replicates, problem.shared_count());
  for (const MinimizeResult& run : runs) {
    if (run.status == Termination::failed) continue;
    bootstrap.converged += run.status == Termination::converged ? 1 : 0;
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
