#include "samara/identification/fit_options.h"

#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::identification {

namespace {

void require_positive(const std::string& field, double value) {
  if (std::isfinite(value) && value > 0.0) return;
  throw ArgumentError(fmt::format("{} is {}; a positive number was expected", field, value));
}

void require_at_least_one(const std::string& field, int value) {
  if (value < 1) throw ArgumentError(fmt::format("{} is {}; at least 1 was expected", field, value));
}

}  // namespace

void validate(const FitOptions& options) {
  if (options.window) require_positive("window", *options.window);
  require_positive("loss.length_scale", options.loss.length_scale);
  for (const auto& [output, scale] : options.loss.scales) {
    require_positive(fmt::format("the loss scale of \"{}\"", output), scale);
  }
  for (const auto& [name, value] : options.fixed) {
    if (!std::isfinite(value))
      throw ArgumentError(fmt::format("\"{}\" is fixed at {}; a finite number was expected", name, value));
  }
  for (const auto& [name, interval] : options.box) {
    if (interval.width() > 0.0 && std::isfinite(interval.width())) continue;
    throw ArgumentError(
        fmt::format("the box of \"{}\" goes from {} to {}; an interval with a length was expected", name,
                    interval.lower, interval.upper));
  }
  require_at_least_one("starts", options.starts);
  constexpr int kMostStarts = 10000;
  if (options.starts > kMostStarts) {
    throw ArgumentError(fmt::format("starts is {}; at most {} was expected", options.starts, kMostStarts));
  }
  require_at_least_one("max_iterations", options.max_iterations);
  require_at_least_one("rounds", options.rounds);
  if (options.averaged_frames < 1 || options.averaged_frames % 2 == 0) {
    throw ArgumentError(fmt::format("averaged_frames is {}; an odd number, at least 1, was expected",
                                    options.averaged_frames));
  }
}

}  // namespace samara::identification
