#include "samara/identification/capture.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

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

Capture first(const Capture& capture, double seconds) {
  if (!(seconds > 0.0))
    throw ArgumentError(fmt::format("a window is {} s long; more than 0 s was expected", seconds));
  const Eigen::Index count = frames_within(capture, seconds);
  if (count < 3) {
    throw ArgumentError(
        fmt::format("a window of {} s leaves {} frames of capture \"{}\"; at least 3 were expected", seconds,
                    count, capture.id));
  }
  Capture part = capture;
  part.times.conservativeResize(count);
  for (Channel& channel : part.channels) channel.values.conservativeResize(count);
  return part;
}

}  // namespace samara::identification
