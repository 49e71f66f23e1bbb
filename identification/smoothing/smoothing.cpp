#include "samara/identification/smoothing/smoothing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/identification/smoothing/continuous_angles.h"
#include "samara/identification/smoothing/local_polynomial.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/smoothing/smoothing_checks.h"

namespace samara::identification {

namespace {

using Eigen::Index;

/// Deviations below it are rounding. Where many frames have the same value, it was rounded to the smallest
/// step between values.
double least_noise(const Eigen::VectorXd& values) {
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  const double rounding = std::max(1e-13 * std::max(std::abs(sorted.front()), std::abs(sorted.back())),
                                   std::numeric_limits<double>::min());
  double step = std::numeric_limits<double>::infinity();
  std::size_t repeated = 0;
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    if (sorted[k] > sorted[k - 1]) {
      step = std::min(step, sorted[k] - sorted[k - 1]);
    } else {
      ++repeated;
    }
  }
  const bool is_rounded = 4 * repeated > sorted.size() && std::isfinite(step);
  return std::max(is_rounded ? step / std::sqrt(12.0) : 0.0, rounding);
}

/// The seen frames of a channel.
struct SeenChannel {
  std::vector<Index> frame;
  LocalFrames frames;
  Eigen::VectorXd values;
};

SeenChannel seen_channel(const Eigen::VectorXd& times, const Eigen::VectorXd& values,
                         const SmoothingOptions& options) {
  SeenChannel seen;
  for (Index i = 0; i < values.size(); ++i) {
    if (!std::isnan(values[i])) seen.frame.push_back(i);
  }
  seen.frames = seen_frames(times, seen.frame, options);
  seen.values = values(seen.frame);
  return seen;
}

void smooth_channel(const Eigen::VectorXd& times, const Eigen::VectorXd& values, const Eigen::VectorXd& at,
                    const SmoothingOptions& options, Index channel, Smoothed& result) {
  SeenChannel seen = seen_channel(times, values, options);
  const auto chart = [&](Index, const std::vector<Index>& frames) -> Eigen::MatrixXd {
    Eigen::MatrixXd rows(static_cast<Index>(frames.size()), 1);
    for (Index k = 0; k < rows.rows(); ++k) rows(k, 0) = seen.values[frames[static_cast<std::size_t>(k)]];
    return rows;
  };
  weigh_outliers(seen.frames, chart, 1, {options.outlier_threshold, options.noise, least_noise(seen.values)});
  for (std::size_t k = 0; k < seen.frame.size(); ++k) {
    result.outlier(seen.frame[k], channel) = seen.frames.weights[static_cast<Index>(k)] == 0.0;
  }
  const double noise = options.noise ? *options.noise : residual_noise(seen.frames, chart, 1);
  result.noise[channel] = noise;
  for (Index row = 0; row < at.size(); ++row) {
    const std::vector<Index> used = seen.frames.around(at[row]);
    const LocalPolynomial fit = fit_local(
        seen.frames, used, at[row], Eigen::VectorXd::Ones(static_cast<Index>(used.size())), chart(0, used));
    result.value(row, channel) = fit.derivatives(0, 0);
    result.rate(row, channel) = fit.derivatives(1, 0);
    result.acceleration(row, channel) = fit.derivatives(2, 0);
    result.value_error(row, channel) = noise * fit.deviations[0];
    result.rate_error(row, channel) = noise * fit.deviations[1];
    result.acceleration_error(row, channel) = noise * fit.deviations[2];
    result.span(row, channel) = fit.span;
  }
}

}  // namespace

Smoothed smooth(const Eigen::VectorXd& times, const Eigen::MatrixXd& values, const Eigen::VectorXd& at,
                const SmoothingOptions& options) {
  check_smoothing(times, values.rows(), at, options);
  for (Index channel = 0; channel < values.cols(); ++channel) {
    if (values.col(channel).array().isInf().any())
      throw ArgumentError(fmt::format("channel {} has an infinite value", channel));
    check_seen_frames(values.rows() - values.col(channel).array().isNaN().count(), options);
  }
  Smoothed result;
  for (Eigen::MatrixXd* field : {&result.value, &result.rate, &result.acceleration, &result.value_error,
                                 &result.rate_error, &result.acceleration_error, &result.span}) {
    field->resize(at.size(), values.cols());
  }
  result.noise.resize(values.cols());
  result.outlier.setConstant(values.rows(), values.cols(), false);
  for (Index channel = 0; channel < values.cols(); ++channel) {
    smooth_channel(times, values.col(channel), at, options, channel, result);
  }
  return result;
}

Smoothed smooth_angle(const Eigen::VectorXd& times, const Eigen::VectorXd& angles, double period,
                      const Eigen::VectorXd& at, const SmoothingOptions& options) {
  return smooth(times, unwrapped(times, angles, period), at, options);
}

LocalFrames seen_frames(const Eigen::VectorXd& times, const std::vector<Index>& seen,
                        const SmoothingOptions& options) {
  const double interval = median_interval(times);
  return {.times = times(seen),
          .weights = {},
          .degree = options.degree,
          .bandwidth = options.bandwidth.value_or(15.0 * interval),
          .averaged = options.averaged_frames,
          .interval = interval};
}

void check_times(const Eigen::VectorXd& times, Index rows) {
  if (times.size() != rows)
    throw ArgumentError(fmt::format("there are {} times for {} frames", times.size(), rows));
  for (Index k = 0; k < times.size(); ++k) {
    if (!std::isfinite(times[k])) throw ArgumentError(fmt::format("the time of frame {} is not finite", k));
    if (k > 0 && times[k] <= times[k - 1]) {
      throw ArgumentError(
          fmt::format("time {} s follows {} s; times that increase were expected", times[k], times[k - 1]));
    }
  }
}

void check_smoothing(const Eigen::VectorXd& times, Index rows, const Eigen::VectorXd& at,
                     const SmoothingOptions& options) {
  constexpr const char* kWhere = "smoothing";
  require(options.degree >= 2 && options.degree <= 6, "degree", options.degree, "2 to 6", kWhere);
  if (options.bandwidth) require_positive(*options.bandwidth, "bandwidth [s]", kWhere);
  if (options.noise) require_not_negative(*options.noise, "noise", kWhere);
  require(options.averaged_frames >= 1, "averaged_frames", options.averaged_frames, "1 or more", kWhere);
  require(options.outlier_threshold > 0.0, "outlier_threshold", options.outlier_threshold, "more than 0",
          kWhere);
  check_times(times, rows);
  check_seen_frames(times.size(), options);
  const double slack = median_interval(times);
  for (const double t : at) {
    if (t >= times[0] - slack && t <= times[times.size() - 1] + slack) continue;
    throw ArgumentError(fmt::format("{} s was asked for; the frames are from {} s to {} s", t, times[0],
                                    times[times.size() - 1]));
  }
}

void check_seen_frames(Index count, const SmoothingOptions& options) {
  if (count >= least_frames(options.degree)) return;
  throw ArgumentError(fmt::format("a channel is seen in {} frames; at least {} were expected for degree {}",
                                  count, least_frames(options.degree), options.degree));
}

}  // namespace samara::identification
