#include "samara/identification/problem/noise_scales.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/smoothing/smoothing.h"

namespace samara::identification {

namespace {

/// Scatter below this share of the spread is rounding.
constexpr double kRounding = 1e-9;

/// Of one capture; none where it has too few frames.
std::optional<double> scatter(const Capture& capture, const std::string& output, double period) {
  constexpr int kFrames = 8;
  if (!capture.has(output)) return {};
  const Eigen::VectorXd& values = capture.channel(output).values;
  if (values.size() != capture.times.size()) return {};
  if ((values.array() == values.array()).count() < kFrames) return {};
  const Eigen::VectorXd at = capture.times.head(1);
  try {
    const Smoothed smoothed =
        period > 0.0 ? smooth_angle(capture.times, values, period, at) : smooth(capture.times, values, at);
    return smoothed.noise[0];
  } catch (const ArgumentError&) {
    return {};  // times that do not increase and the like; who reads the capture for the fit says so
  }
}

double spread_of(std::span<const Capture> captures, const std::string& output) {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const Capture& capture : captures) {
    if (!capture.has(output)) continue;
    for (const double value : capture.channel(output).values) {
      if (!std::isfinite(value)) continue;
      lowest = std::min(lowest, value);
      highest = std::max(highest, value);
    }
  }
  return highest > lowest ? highest - lowest : 1.0;
}

}  // namespace

bool noise_is_estimated(const NoiseOptions& options, const std::string& output) {
  return options.estimated && (options.levels.empty() || options.levels.contains(output));
}

double frame_scatter(std::span<const Capture> captures, const std::string& output, double period) {
  constexpr double kShare = 1e-3;
  const double spread = spread_of(captures, output);
  std::vector<double> all;
  for (const Capture& capture : captures) {
    const std::optional<double> one = scatter(capture, output, period);
    if (one && *one > kRounding * spread) all.push_back(*one);
  }
  return all.empty() ? kShare * spread : median(all);
}

}  // namespace samara::identification
