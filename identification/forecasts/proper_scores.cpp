#include "samara/identification/forecasts/proper_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::identification {

namespace {

constexpr double kNotSaid = std::numeric_limits<double>::quiet_NaN();

double normal_density(double z) {
  return std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
}

double normal_below(double z) {
  return 0.5 * std::erfc(-z / std::numbers::sqrt2);
}

/// E|X| of a normal X.
double mean_distance(double mean, double deviation) {
  if (deviation == 0.0) return std::abs(mean);
  const double z = mean / deviation;
  return 2.0 * deviation * normal_density(z) + mean * (2.0 * normal_below(z) - 1.0);
}

void check_mixture(const NormalMixture& mixture) {
  const Eigen::Index count = mixture.weights.size();
  if (count == 0 || mixture.means.size() != count || mixture.deviations.size() != count) {
    throw ArgumentError(fmt::format(
        "a mixture has {} weights, {} means and {} deviations; as many of each were expected, and "
        "one or more",
        count, mixture.means.size(), mixture.deviations.size()));
  }
  for (Eigen::Index k = 0; k < count; ++k) {
    const bool is_sound = mixture.weights[k] >= 0.0 && mixture.deviations[k] >= 0.0 &&
                          std::isfinite(mixture.means[k]) && std::isfinite(mixture.deviations[k]);
    if (is_sound) continue;
    throw ArgumentError(fmt::format(
        "a member of a mixture has the weight {}, the mean {} and the deviation {}; a finite mean, "
        "and the others 0 or more were expected",
        mixture.weights[k], mixture.means[k], mixture.deviations[k]));
  }
  constexpr double kRounding = 1e-6;
  if (std::abs(mixture.weights.sum() - 1.0) <= kRounding) return;
  throw ArgumentError(
      fmt::format("the weights of a mixture are {} together; 1 was expected", mixture.weights.sum()));
}

void check_part(double part) {
  if (part > 0.0 && part < 1.0) return;
  throw ArgumentError(
      fmt::format("a part of a distribution is {}; more than 0 and less than 1 was expected", part));
}

/// P(X <= x), or P(X < x).
double below(const NormalMixture& mixture, double x, bool or_at = true) {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < mixture.weights.size(); ++k) {
    const double away = x - mixture.means[k];
    const double deviation = mixture.deviations[k];
    const double part =
        deviation > 0.0 ? normal_below(away / deviation) : (away > 0.0 || (or_at && away == 0.0) ? 1.0 : 0.0);
    sum += mixture.weights[k] * part;
  }
  return sum;
}

}  // namespace

double probability_below(const NormalMixture& mixture, double x) {
  check_mixture(mixture);
  if (std::isnan(x))
    throw ArgumentError("the number to compare with a mixture is NaN; a number was expected");
  return below(mixture, x);
}

double quantile(const NormalMixture& mixture, double part) {
  check_mixture(mixture);
  check_part(part);
  // No member has more than 1e-300 beyond 40 deviations.
  constexpr double kFar = 40.0;
  double low = (mixture.means - kFar * mixture.deviations).minCoeff();
  double high = (mixture.means + kFar * mixture.deviations).maxCoeff();
  for (int halving = 0; halving < 200 && low < high; ++halving) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    (below(mixture, middle) < part ? low : high) = middle;
  }
  return high;
}

double crps(const NormalMixture& mixture, double measured) {
  check_mixture(mixture);
  if (!std::isfinite(measured)) {
    throw ArgumentError(fmt::format(
        "the measured value to score a forecast with is {}; a finite one was expected", measured));
  }
  const Eigen::VectorXd& w = mixture.weights;
  double to_truth = 0.0, among = 0.0;
  for (Eigen::Index i = 0; i < w.size(); ++i) {
    to_truth += w[i] * mean_distance(measured - mixture.means[i], mixture.deviations[i]);
    for (Eigen::Index j = 0; j < w.size(); ++j) {
      among += w[i] * w[j] *
               mean_distance(mixture.means[i] - mixture.means[j],
                             std::hypot(mixture.deviations[i], mixture.deviations[j]));
    }
  }
  return to_truth - 0.5 * among;
}

NormalMixture marginal(const Forecast& forecast, Eigen::Index time, Eigen::Index output) {
  std::vector<double> weights, means, deviations;
  for (const ForecastComponent& component : forecast.components) {
    const auto times = static_cast<Eigen::Index>(component.covariance.size());
    if (component.mean.rows() != forecast.times.size() || times != forecast.times.size() ||
        component.mean.cols() != std::ssize(forecast.outputs)) {
      throw ArgumentError(fmt::format(
          "a component of a forecast of {} times and {} outputs has means of {} x {} and {} covariances",
          forecast.times.size(), forecast.outputs.size(), component.mean.rows(), component.mean.cols(),
          times));
    }
    if (time < 0 || time >= times || output < 0 || output >= component.mean.cols()) {
      throw ArgumentError(
          fmt::format("output {} at time {} of a forecast of {} outputs at {} times was asked for", output,
                      time, component.mean.cols(), times));
    }
    const Eigen::MatrixXd& covariance = component.covariance[static_cast<std::size_t>(time)];
    if (covariance.rows() != component.mean.cols() || covariance.cols() != component.mean.cols()) {
      throw ArgumentError(fmt::format("a covariance of a forecast of {} outputs is {} x {}",
                                      component.mean.cols(), covariance.rows(), covariance.cols()));
    }
    if (std::isnan(component.mean(time, output))) continue;
    const double variance = covariance(output, output);
    if (!(variance >= 0.0) || !std::isfinite(variance)) {
      throw ArgumentError(fmt::format(
          "the variance of a forecast is {}; a finite number, 0 or more, was expected", variance));
    }
    weights.push_back(component.weight);
    means.push_back(component.mean(time, output));
    deviations.push_back(std::sqrt(variance));
  }
  const auto count = static_cast<Eigen::Index>(weights.size());
  NormalMixture mixture{Eigen::Map<const Eigen::VectorXd>(weights.data(), count),
                        Eigen::Map<const Eigen::VectorXd>(means.data(), count),
                        Eigen::Map<const Eigen::VectorXd>(deviations.data(), count)};
  if (count > 0) mixture.weights /= mixture.weights.sum();
  return mixture;
}

void ProperScores::add(const NormalMixture& mixture, double measured, int cluster) {
  if (std::isnan(measured)) return;
  crps_.push_back(crps(mixture, measured));
  below_.push_back(std::clamp(0.5, below(mixture, measured, false), below(mixture, measured)));
  clusters_.push_back(cluster);
}

void ProperScores::add(const Forecast& forecast, const Eigen::MatrixXd& measured, int cluster) {
  if (measured.rows() != forecast.times.size() || measured.cols() != std::ssize(forecast.outputs)) {
    throw ArgumentError(fmt::format("a forecast of {} times and {} outputs was compared with {} x {} values",
                                    forecast.times.size(), forecast.outputs.size(), measured.rows(),
                                    measured.cols()));
  }
  for (Eigen::Index time = 0; time < measured.rows(); ++time) {
    for (Eigen::Index output = 0; output < measured.cols(); ++output) {
      const NormalMixture mixture = marginal(forecast, time, output);
      if (mixture.weights.size() > 0) add(mixture, measured(time, output), cluster);
    }
  }
}

double ProperScores::mean_crps() const {
  if (crps_.empty()) return kNotSaid;
  return std::accumulate(crps_.begin(), crps_.end(), 0.0) / static_cast<double>(crps_.size());
}

double ProperScores::coverage(double part) const {
  check_part(part);
  if (below_.empty()) return kNotSaid;
  int inside = 0;
  for (std::size_t k = 0; k < below_.size(); ++k) inside += is_inside(k, part) ? 1 : 0;
  return static_cast<double>(inside) / static_cast<double>(below_.size());
}

double ProperScores::coverage_error(double part) const {
  const double share = coverage(part);
  std::map<int, double> excesses;  // of numbers inside over those expected, by cluster
  for (std::size_t k = 0; k < below_.size(); ++k)
    excesses[clusters_[k]] += (is_inside(k, part) ? 1.0 : 0.0) - share;
  const auto count = static_cast<double>(excesses.size());
  if (count < 2.0) return kNotSaid;
  double squares = 0.0;
  for (const auto& [cluster, excess] : excesses) squares += excess * excess;
  return std::sqrt(count / (count - 1.0) * squares) / static_cast<double>(below_.size());
}

bool ProperScores::is_inside(std::size_t k, double part) const {
  return std::abs(below_[k] - 0.5) <= 0.5 * part;
}

}  // namespace samara::identification
