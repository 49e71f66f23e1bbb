#include "samara/identification/captures/capture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

bool Capture::has(const std::string& quantity) const {
  return std::ranges::count(channels, quantity, &Channel::quantity) > 0;
}

const Channel& Capture::channel(const std::string& quantity) const {
  const auto found = std::ranges::find(channels, quantity, &Channel::quantity);
  if (found != channels.end()) return *found;
  std::vector<std::string> known;
  for (const Channel& candidate : channels) known.push_back(candidate.quantity);
  throw ArgumentError(
      fmt::format("capture \"{}\" does not measure \"{}\"{}", id, quantity, suggestion(quantity, known)));
}

void refuse(const std::string& file, const std::string& sentence) {
  if (file.empty()) throw ArgumentError(sentence);
  throw InputError(file, sentence);
}

void check_sizes(const Capture& capture) {
  for (const Channel& channel : capture.channels) {
    if (channel.values.size() == capture.times.size()) continue;
    refuse(capture.file,
           fmt::format("capture \"{}\" has {} values of \"{}\"; one for each of its {} frames was expected",
                       capture.id, channel.values.size(), channel.quantity, capture.times.size()));
  }
}

bool is_angle(const Channel& channel) {
  const std::vector<std::string> names = {"theta", "phi", "psi", "roll", "pitch", "yaw"};
  return channel.unit == "1" && std::ranges::count(names, channel.quantity) > 0;
}

Eigen::Index frames_within(const Capture& capture, double seconds) {
  const Eigen::VectorXd& times = capture.times;
  Eigen::Index count = 0;
  if (times.size() == 0) return count;
  const auto intervals = static_cast<double>(std::max<Eigen::Index>(1, times.size() - 1));
  const double end = times[0] + seconds + 1e-3 * (times[times.size() - 1] - times[0]) / intervals;
  while (count < times.size() && times[count] <= end) ++count;
  return count;
}

namespace {

/// Whether enough of the frames between two are seen.
bool is_seen(const Capture& capture, Eigen::Index first, Eigen::Index count, double length, double interval,
             const std::vector<std::string>& quantities) {
  const auto counts = [&](const Channel& channel) {
    return quantities.empty() || std::ranges::count(quantities, channel.quantity) > 0;
  };
  double seen = 0.0;
  for (Eigen::Index k = first; k < first + count; ++k) {
    const auto has = [&](const Channel& channel) {
      return !counts(channel) || std::isfinite(channel.values[k]);
    };
    const auto shows = [&](const Channel& channel) {
      return counts(channel) && std::isfinite(channel.values[k]);
    };
    const bool all = std::ranges::all_of(capture.channels, has);
    seen += quantities.empty() ? std::ranges::any_of(capture.channels, shows) : all;
  }
  return seen >= 3.0 && seen >= 0.5 * length / interval;
}

}  // namespace

std::vector<Capture> spans(const Capture& capture, double length, double stride,
                           const std::vector<std::string>& quantities) {
  for (const auto& [name, value] : {std::pair{"a span", length}, {"the stride of spans", stride}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    throw ArgumentError(fmt::format("{} is {} s long; more than 0 s was expected", name, value));
  }
  check_sizes(capture);
  std::vector<Capture> parts;
  const Eigen::VectorXd& times = capture.times;
  if (times.size() < 3) return parts;
  const double interval = median_interval(times);
  const double rounding = 1e-3 * interval;
  double wanted = times[0];
  for (Eigen::Index begin = 0; begin < times.size(); ++begin) {
    if (times[begin] < wanted - rounding) continue;
    // The frame after the last one would still belong to it.
    if (times[times.size() - 1] + interval <= times[begin] + length + rounding) break;
    wanted = times[begin] + stride;
    Eigen::Index count = 0;
    while (begin + count < times.size() && times[begin + count] <= times[begin] + length + rounding) ++count;
    if (!is_seen(capture, begin, count, length, interval, quantities)) continue;
    Capture part = capture;
    part.motion = capture.whole();
    part.id = span_id(part.motion, times[begin]);
    part.times = times.segment(begin, count).array() - times[begin];
    part.shift = capture.shift + times[begin];
    for (Channel& channel : part.channels) channel.values = channel.values.segment(begin, count).eval();
    parts.push_back(std::move(part));
  }
  return parts;
}

std::string span_id(const std::string& capture, double begin) {
  // Nine digits tell frames of hours apart, and hide the rounding of the last ones.
  return fmt::format("{} from {:.9g} s", capture, begin);
}

namespace {

/// Frames [begin, begin + count) of a capture.
Capture frames_of_part(const Capture& capture, Eigen::Index begin, Eigen::Index count) {
  Capture part = capture;
  part.times = capture.times.segment(begin, count).eval();
  for (Channel& channel : part.channels) channel.values = channel.values.segment(begin, count).eval();
  return part;
}

}  // namespace

Capture known_at(const Capture& capture, double seconds) {
  const Eigen::Index count = frames_within(capture, seconds);
  if (count == 0 || !capture.before_cleaning) return frames_of_part(capture, 0, count);
  // By numbers of frames: a frame grid may move the clock by more than an interval.
  const BeforeCleaning& before = *capture.before_cleaning;
  const Eigen::VectorXd& clock = before.times;
  const double rounding = 1e-3 * (clock[clock.size() - 1] - clock[0]) / static_cast<double>(clock.size());
  const auto number_at = [&](double time) {
    return std::lower_bound(clock.begin(), clock.end(), time + capture.shift - rounding) - clock.begin();
  };
  const Eigen::Index first = number_at(capture.times[0]), last = number_at(capture.times[count - 1]);
  const Eigen::Index seen = std::min(last + 1, before.capture.times.size());
  const Capture cleaned = before.clean(frames_of_part(before.capture, 0, seen));
  if (first >= cleaned.times.size()) {
    throw ArgumentError(
        fmt::format("cleaning without later frames leaves nothing of the first {} s of capture \"{}\"",
                    seconds, capture.id));
  }
  Capture known = frames_of_part(cleaned, first, cleaned.times.size() - first);
  known.times.array() += capture.times[0] - known.times[0];
  known.id = capture.id;
  known.motion = capture.motion;
  known.shift = capture.shift;
  return known;
}

Capture first(const Capture& capture, double seconds) {
  if (!(seconds > 0.0))
    throw ArgumentError(fmt::format("a span is {} s long; more than 0 s was expected", seconds));
  check_sizes(capture);
  const Eigen::Index count = frames_within(capture, seconds);
  if (count < 3) {
    throw ArgumentError(
        fmt::format("a span of {} s leaves {} frames of capture \"{}\"; at least 3 were expected", seconds,
                    count, capture.id));
  }
  Capture part = capture;
  part.times.conservativeResize(count);
  for (Channel& channel : part.channels) channel.values.conservativeResize(count);
  return part;
}

}  // namespace samara::identification
