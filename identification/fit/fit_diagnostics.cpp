#include "samara/identification/fit/fit_diagnostics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/parallel.h"
#include "samara/identification/fit/held_fits.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/posterior.h"
#include "samara/identification/statistics/cluster_errors.h"
#include "samara/identification/statistics/determined_inverse.h"
#include "samara/identification/statistics/loss.h"

namespace samara::identification {

namespace {

/// Noise of a millionth of the loss scale: less is none, and what is left of the cost is rounding.
constexpr double kLeastDispersion = 1e-12;

double usable(double dispersion) {
  return std::isnan(dispersion) ? 1.0 : std::max(dispersion, kLeastDispersion);
}

/// One over the diagonal of the inverse information: the curvature of the profile of a coefficient. Others that lie
/// at a bound stay there while it is held. 0 where it is not determined.
double profile_curvature(const Uncertainty& uncertainty, std::size_t coefficient) {
  std::vector<int> free;
  std::size_t place = 0;
  for (std::size_t k = 0; k < uncertainty.at_bound.size(); ++k) {
    if (k == coefficient) place = free.size();
    if (k == coefficient || !uncertainty.at_bound[k]) free.push_back(static_cast<int>(k));
  }
  const Eigen::MatrixXd information = uncertainty.information(free, free);
  const DeterminedInverse inverse = invert_determined(information, Eigen::VectorXd::Zero(information.rows()));
  const auto at = static_cast<Eigen::Index>(place);
  return inverse.determined[place] ? 1.0 / inverse.inverse(at, at) : 0.0;
}

/// The dispersion with which a profile has the width of the coefficient's standard error, at a bound of the one that
/// it would have if it were free; and the degrees of freedom on which that rests: from clusters where the error is,
/// else from what is left over of the frames.
ProfileOptions profile_options(const FitProblem& problem, const Uncertainty& uncertainty,
                               const Coefficient& c, std::size_t coefficient) {
  const auto at = static_cast<Eigen::Index>(coefficient);
  const double error = c.standard_error.value_or(c.naive_standard_error.value_or(0.0));
  const bool is_released = uncertainty.released_variance[at] > 0.0;
  const double variance = is_released ? uncertainty.released_variance[at] : error * error;
  const double dispersion = variance * profile_curvature(uncertainty, coefficient);
  ProfileOptions options{.dispersion = usable(dispersion > 0.0 ? dispersion : uncertainty.dispersion)};
  const double clusters =
      is_released ? uncertainty.released_clusters[at] : c.effective_clusters.value_or(problem.cluster_count);
  options.degrees_of_freedom = is_released || c.standard_error
                                   ? error_degrees(clusters, problem.cluster_count)
                                   : std::max(1, uncertainty.residual_freedom);
  return options;
}

std::span<const double> span_of(const Eigen::VectorXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

/// The larger of the naive dispersion and the mean of what the clusters say, trace(V H)/p.
double overall_dispersion(const Uncertainty& uncertainty, const FitResult& result) {
  double trace = 0.0;
  int count = 0;
  for (Eigen::Index i = 0; i < result.covariance.rows(); ++i) {
    if (std::isnan(result.covariance(i, i))) continue;
    for (Eigen::Index k = 0; k < result.covariance.rows(); ++k) {
      if (!std::isnan(result.covariance(i, k)))
        trace += result.covariance(i, k) * uncertainty.information(k, i);
    }
    ++count;
  }
  return std::max(usable(uncertainty.dispersion), count > 0 ? trace / count : 0.0);
}

}  // namespace

void add_whiteness(FitResult& result) {
  std::vector<SeriesWhiteness> all;
  for (const CaptureFit& capture : result.captures) {
    for (Eigen::Index column = 0; column < capture.measured.cols(); ++column) {
      const auto o = static_cast<std::size_t>(column);
      const Eigen::VectorXd residual = capture.measured.col(column) - capture.model.col(column);
      SeriesWhiteness series = series_whiteness(span_of(capture.times), span_of(residual));
      series.capture = capture.id;
      series.output = capture.residuals[o].output;
      all.push_back(std::move(series));
    }
  }
  result.whiteness = pool_whiteness(std::move(all));
}

void add_identifiability(const FitProblem& problem, const Uncertainty& uncertainty, FitResult& result) {
  if (result.coefficients.empty()) return;
  std::vector<InformedCoefficient> coefficients;
  Eigen::MatrixXd information = uncertainty.information;
  for (std::size_t k = 0; k < result.coefficients.size(); ++k) {
    const Coefficient& c = result.coefficients[k];
    coefficients.push_back({.name = c.name, .value = c.value, .scale = 0.5 * (c.upper - c.lower)});
    if (!problem.shared_chart.is_logarithmic(static_cast<int>(k))) continue;
    coefficients.back().scale = 0.5 * std::log(c.upper / c.lower);
    coefficients.back().log_scaled = true;
    information.row(static_cast<Eigen::Index>(k)) *= c.value;
    information.col(static_cast<Eigen::Index>(k)) *= c.value;
  }
  result.identifiability =
      identifiability(coefficients, information, overall_dispersion(uncertainty, result));
}

void add_profiles(const models::TrajectoryFamily& family, const FitProblem& problem,
                  const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                  const Uncertainty& uncertainty, int max_iterations, FitResult& result) {
  result.profiles.resize(result.coefficients.size());
  std::vector<long> evaluations(result.coefficients.size());
  parallel_for(result.coefficients.size(), [&](std::size_t k) {
    const Coefficient& c = result.coefficients[k];
    const ProfileTarget target{.name = c.name,
                               .best = c.value,
                               .best_cost = result.cost,
                               .scale = c.standard_error.value_or(c.naive_standard_error.value_or(0.0)),
                               .lower = c.lower,
                               .upper = c.upper};
    HeldFits fits(family, problem, residuals, point, static_cast<int>(k), max_iterations);
    result.profiles[k] = profile(
        target, packed(point),
        [&](double value, const Eigen::VectorXd& neighbour) { return fits.solve(value, neighbour); },
        profile_options(problem, uncertainty, c, k));
    evaluations[k] = fits.evaluations();
  });
  result.evaluations += std::accumulate(evaluations.begin(), evaluations.end(), 0L);
}

std::string describe_unsettled(const Posterior& posterior) {
  const auto& unknowns = posterior.unknowns;
  const auto worst = std::ranges::max_element(unknowns, {}, &PosteriorUnknown::rhat);
  const auto fewest = std::ranges::min_element(unknowns, {}, &PosteriorUnknown::effective);
  return fmt::format(
      "the posterior is not settled: R-hat of {} is {:.3f} (1.01 or less was expected), {} has {:.0f} "
      "effective draws (400 or more), and {} proposals diverged (none): more samples or priors are "
      "needed",
      worst->name, worst->rhat, fewest->name, fewest->effective, posterior.divergences);
}

void add_posterior(const models::TrajectoryFamily& family, const FitProblem& problem,
                   const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                   const Uncertainty& uncertainty, const FitOptions& options, FitResult& result) {
  if (options.uncertainty.posterior.samples < 1) return;
  Outcome<Posterior> drawn = sample_posterior(family, problem, residuals, point, uncertainty.dispersion,
                                              options.uncertainty.posterior);
  if (!drawn) {
    result.warnings.add(WarningKind::errors, fmt::format("no posterior: {}", drawn.ending().message));
    return;
  }
  result.posterior = std::move(*drawn);
  result.evaluations += result.posterior->evaluations;
  if (result.posterior->is_settled()) return;
  result.warnings.add(WarningKind::errors, describe_unsettled(*result.posterior));
}

void add_profile_warnings(FitResult& result) {
  for (const Profile& p : result.profiles) {
    const Coefficient& c = *std::ranges::find(result.coefficients, p.name, &Coefficient::name);
    if (p.shape == ProfileShape::better_elsewhere) {
      result.warnings.add(
          WarningKind::optima,
          fmt::format("the profile of {} met a {}: the fit ended in a local optimum; more starts are advised",
                      p.name, describe(p)));
    } else if (p.shape != ProfileShape::identified && c.determined && !c.at_bound) {
      result.warnings.add(
          WarningKind::undetermined,
          fmt::format("the captures determine {} to one side at most: {}", p.name, describe(p)));
    }
  }
}

}  // namespace samara::identification
