#include "samara/identification/problem/fit_options.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"

namespace samara::identification {

namespace {

void require_at_least_one(std::string_view field, int value) {
  require(value >= 1, field, value, "at least 1");
}

constexpr std::array kGlobalNames = {
    std::pair{GlobalMethod::none, "none"}, std::pair{GlobalMethod::controlled_random, "crs"},
    std::pair{GlobalMethod::direct, "direct"}, std::pair{GlobalMethod::evolution, "isres"}};

}  // namespace

std::string to_string(GlobalMethod method) {
  return std::ranges::find(kGlobalNames, method, [](const auto& pair) { return pair.first; })->second;
}

GlobalMethod global_method_from_string(const std::string& name) {
  std::vector<std::string> known;
  for (const auto& [method, text] : kGlobalNames) {
    if (name == text) return method;
    known.push_back(text);
  }
  throw ArgumentError(fmt::format("there is no global search \"{}\"{}", name, suggestion(name, known)));
}

void validate(const FitOptions& options) {
  if (options.window) require_positive(*options.window, "window");
  if (options.stride) {
    require_positive(*options.stride, "stride");
    if (!options.window)
      throw ArgumentError("stride is set without window; the length of a window was expected");
  }
  require_positive(options.loss.length_scale, "loss.length_scale");
  for (const auto& [output, scale] : options.loss.scales) {
    require_positive(scale, fmt::format("the loss scale of \"{}\"", output));
  }
  for (const auto& [name, value] : options.fixed) {
    require(std::isfinite(value), fmt::format("the fixed value of \"{}\"", name), value, "a finite number");
  }
  for (const auto& [name, interval] : options.box) {
    if (interval.width() > 0.0 && std::isfinite(interval.width())) continue;
    throw ArgumentError(
        fmt::format("the box of \"{}\" goes from {} to {}; an interval with a length was expected", name,
                    interval.lower, interval.upper));
  }
  if (options.step) require_positive(*options.step, "step");
  if (options.segments.length) require_positive(*options.segments.length, "segments.length");
  if (options.segments.stages.empty()) {
    throw ArgumentError("segments.stages is empty; one weight or more was expected");
  }
  for (const double stage : options.segments.stages) require_positive(stage, "a weight of segments.stages");
  require_positive(options.attitude_scale, "attitude_scale");
  require_at_least_one("noise.rounds", options.noise.rounds);
  if (options.camera.scale) require_positive(*options.camera.scale, "camera.scale");
  if (options.camera.rotation) require_positive(*options.camera.rotation, "camera.rotation");
  for (const auto& [name, prior] : options.priors) {
    require_positive(prior.deviation, fmt::format("the deviation of the prior of \"{}\"", name));
    if (prior.logarithmic) require_positive(prior.mean, fmt::format("the mean of the prior of \"{}\"", name));
    require(std::isfinite(prior.mean), fmt::format("the mean of the prior of \"{}\"", name), prior.mean,
            "a finite number");
  }
  for (const CombinationPrior& prior : options.combinations) {
    require_positive(prior.deviation, "the deviation of a combination");
  }
  for (const auto& [name, period] : options.periods) {
    require(std::isfinite(period) && period >= 0.0, fmt::format("the period of \"{}\"", name), period,
            "0 or more");
  }
  require_at_least_one("global.budget", options.global.budget);
  require_at_least_one("starts", options.starts);
  constexpr int kMostStarts = 10000;
  require(options.starts <= kMostStarts, "starts", options.starts, fmt::format("at most {}", kMostStarts));
  require_at_least_one("max_iterations", options.max_iterations);
  require(options.bootstrap.replicates >= 0, "bootstrap.replicates", options.bootstrap.replicates,
          "0 or more");
  require_at_least_one("rounds", options.rounds);
  require(options.averaged_frames >= 1 && options.averaged_frames % 2 == 1, "averaged_frames",
          options.averaged_frames, "an odd number, at least 1,");
}

}  // namespace samara::identification
