#include "samara/motion/events/event.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"

namespace samara::motion {

const std::vector<std::string>& event_kind_names() {
  static const std::vector<std::string> names = {"swing-", "swing+", "turn-", "turn+"};
  return names;
}

std::string to_string(EventKind kind) {
  return event_kind_names()[static_cast<std::size_t>(kind)];
}

EventKind event_kind_of(std::string_view name) {
  const auto& names = event_kind_names();
  const auto found = std::ranges::find(names, name);
  if (found == names.end())
    throw ArgumentError(fmt::format("\"{}\" is no kind of event, expected one of {}", name, join(names)));
  return static_cast<EventKind>(found - names.begin());
}

EventOptions event_options(double mean_square_speed, double body_length) {
  require_positive(mean_square_speed, "mean square speed");
  require_positive(body_length, "length of the body");
  EventOptions options;
  const double time = body_length / std::sqrt(mean_square_speed);
  options.mean_square_speed = mean_square_speed;
  options.shortest = 0.2 * time;
  options.steady = 2.0 * time;
  return options;
}

}  // namespace samara::motion
