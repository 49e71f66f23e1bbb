#include "samara/identification/captures/capture_cleaning.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/smoothing/smoothing_attitude.h"

namespace samara::identification {

namespace {

using Eigen::Index;
using Flags = Eigen::Array<bool, Eigen::Dynamic, 1>;

/// Smoothing wants to be asked for a time; only its judgement of the frames is used.
Eigen::VectorXd any_time(const Capture& capture) {
  return capture.times.head(1);
}

bool is_enough(const Eigen::VectorXd& values, const SmoothingOptions& options) {
  return values.size() - values.array().isNaN().count() >= options.degree + 2;
}

std::vector<int> indices(const Flags& flags) {
  std::vector<int> frames;
  for (Index i = 0; i < flags.size(); ++i) {
    if (flags[i]) frames.push_back(static_cast<int>(i));
  }
  return frames;
}

bool has_attitude(const Capture& capture) {
  return std::ranges::all_of(kQuaternionChannels, [&](const std::string& q) { return capture.has(q); });
}

bool is_quaternion(const std::string& quantity) {
  return std::ranges::count(kQuaternionChannels, quantity) > 0;
}

Flags attitude_outliers(const Capture& capture, const SmoothingOptions& options) {
  Eigen::MatrixX4d quaternions(capture.times.size(), 4);
  for (Index k = 0; k < 4; ++k)
    quaternions.col(k) = capture.channel(kQuaternionChannels[static_cast<std::size_t>(k)]).values;
  if (!is_enough(quaternions.rowwise().sum(), options)) return Flags::Constant(capture.times.size(), false);
  return smooth_attitude(capture.times, quaternions, any_time(capture), options).outlier;
}

Flags channel_outliers(const Capture& capture, const Channel& channel, const SmoothingOptions& options,
                       const std::map<std::string, double>& periods) {
  if (!is_enough(channel.values, options)) return Flags::Constant(capture.times.size(), false);
  const auto period = periods.find(channel.quantity);
  if (period == periods.end())
    return smooth(capture.times, channel.values, any_time(capture), options).outlier.col(0);
  return smooth_angle(capture.times, channel.values, period->second, any_time(capture), options)
      .outlier.col(0);
}

Eigen::VectorXd position(const Capture& capture, const std::vector<std::string>& quantities, Index frame) {
  Eigen::VectorXd values(static_cast<Index>(quantities.size()));
  for (Index k = 0; k < values.size(); ++k)
    values[k] = capture.channel(quantities[static_cast<std::size_t>(k)]).values[frame];
  return values;
}

}  // namespace

std::vector<Gap> gaps(const Capture& capture, const std::string& quantity) {
  constexpr double kLonger = 1.5;
  const double interval = median_interval(capture.times);
  std::vector<Gap> found;
  std::optional<double> before;
  for (Index i = 0; i < capture.times.size(); ++i) {
    if (!quantity.empty() && std::isnan(capture.channel(quantity).values[i])) continue;
    const double time = capture.times[i];
    if (before && time - *before > kLonger * interval) {
      constexpr double kMost = 1e18;  // times that are mistaken may lie anywhere
      found.push_back({*before, time, std::lround(std::min((time - *before) / interval - 1.0, kMost))});
    }
    before = time;
  }
  return found;
}

std::vector<Capture> continuous_parts(const Capture& capture, const PartOptions& options) {
  if (!(options.longest_gap > 0.0)) {
    throw ArgumentError(
        fmt::format("the longest gap is {} s; more than 0 was expected", options.longest_gap));
  }
  std::vector<std::pair<Index, Index>> ranges;  // first and last frame
  Index seen = 0;                               // in the last range
  const auto close = [&] {
    if (!ranges.empty() && seen < options.least_frames) ranges.pop_back();
  };
  for (Index i = 0; i < capture.times.size(); ++i) {
    const Eigen::VectorXd here = position(capture, options.quantities, i);
    if (here.array().isNaN().any()) continue;
    bool goes_on = seen > 0;
    if (goes_on) {
      const Index last = ranges.back().second;
      const double interval = capture.times[i] - capture.times[last];
      const double step = (here - position(capture, options.quantities, last)).norm();
      goes_on =
          interval <= options.longest_gap && (options.fastest <= 0.0 || step <= options.fastest * interval);
    }
    if (goes_on) {
      ranges.back().second = i;
      ++seen;
    } else {
      close();
      ranges.emplace_back(i, i);
      seen = 1;
    }
  }
  close();
  std::vector<Capture> parts;
  for (const auto& [first, last] : ranges) {
    Capture part = capture;
    part.times = capture.times.segment(first, last + 1 - first);
    for (Channel& channel : part.channels)
      channel.values = channel.values.segment(first, last + 1 - first).eval();
    if (part.frame_count() < capture.frame_count()) {
      part.notes.push_back(fmt::format("a part of {} of {} frames, between gaps or jumps", part.frame_count(),
                                       capture.frame_count()));
    }
    if (ranges.size() > 1) part.id += fmt::format("#{}", parts.size() + 1);
    parts.push_back(std::move(part));
  }
  return parts;
}

WithoutOutliers without_outliers(const Capture& capture, const SmoothingOptions& options,
                                 const std::map<std::string, double>& periods) {
  WithoutOutliers result{.capture = capture, .frames = {}};
  const bool attitude = has_attitude(capture);
  Flags wrong_attitude;
  if (attitude) {
    wrong_attitude = attitude_outliers(capture, options);
    if (wrong_attitude.any()) result.frames["attitude"] = indices(wrong_attitude);
  }
  for (Channel& channel : result.capture.channels) {
    const bool of_attitude = attitude && is_quaternion(channel.quantity);
    const Flags wrong = of_attitude ? wrong_attitude : channel_outliers(capture, channel, options, periods);
    if (!wrong.any()) continue;
    channel.values = wrong.select(std::numeric_limits<double>::quiet_NaN(), channel.values.array()).matrix();
    if (!of_attitude) result.frames[channel.quantity] = indices(wrong);
  }
  for (const auto& [quantity, frames] : result.frames) {
    result.capture.notes.push_back(fmt::format("{} of {} frames of {} taken out: far from their neighbours",
                                               frames.size(), capture.frame_count(), quantity));
  }
  return result;
}

}  // namespace samara::identification
