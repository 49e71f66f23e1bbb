#include "samara/identification/problem/fit_options.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::identification {

namespace {

void require_positive(const std::string& field, double value) {
  if (std::isfinite(value) && value > 0.0) return;
  throw ArgumentError(fmt::format("{} is {}; a positive number was expected", field, value));
}

void require_at_least_one(const std::string& field, int value) {
  if (value < 1) throw ArgumentError(fmt::format("{} is {}; at least 1 was expected", field, value));
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
  if (options.window) require_positive("window", *options.window);
  if (options.stride) {
    require_positive("stride", *options.stride);
    if (!options.window)
      throw ArgumentError("stride is set without window; the length of a window was expected");
  }
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
  if (options.step) require_positive("step", *options.step);
  if (options.segments.length) require_positive("segments.length", *options.segments.length);
  if (options.segments.stages.empty()) {
    throw ArgumentError("segments.stages is empty; one weight or more was expected");
  }
  for (const double stage : options.segments.stages) require_positive("a weight of segments.stages", stage);
  require_positive("attitude_scale", options.attitude_scale);
  require_at_least_one("noise.rounds", options.noise.rounds);
  if (options.camera.scale) require_positive("camera.scale", *options.camera.scale);
  if (options.camera.rotation) require_positive("camera.rotation", *options.camera.rotation);
  for (const auto& [name, prior] : options.priors) {
    require_positive(fmt::format("the deviation of the prior of \"{}\"", name), prior.deviation);
    if (prior.logarithmic) require_positive(fmt::format("the mean of the prior of \"{}\"", name), prior.mean);
    if (!std::isfinite(prior.mean)) {
      throw ArgumentError(fmt::format("the mean of the prior of \"{}\" is {}; a finite number was expected",
                                      name, prior.mean));
    }
  }
  for (const CombinationPrior& prior : options.combinations) {
    require_positive("the deviation of a combination", prior.deviation);
  }
  for (const auto& [name, period] : options.periods) {
    if (!(std::isfinite(period) && period >= 0.0)) {
      throw ArgumentError(fmt::format("the period of \"{}\" is {}; 0 or more was expected", name, period));
    }
  }
  require_at_least_one("global.budget", options.global.budget);
  require_at_least_one("starts", options.starts);
  constexpr int kMostStarts = 10000;
  if (options.starts > kMostStarts) {
    throw ArgumentError(fmt::format("starts is {}; at most {} was expected", options.starts, kMostStarts));
  }
  require_at_least_one("max_iterations", options.max_iterations);
  if (options.bootstrap.replicates < 0) {
    throw ArgumentError(
        fmt::format("bootstrap.replicates is {}; 0 or more was expected", options.bootstrap.replicates));
  }
  require_at_least_one("rounds", options.rounds);
  if (options.averaged_frames < 1 || options.averaged_frames % 2 == 0) {
    throw ArgumentError(fmt::format("averaged_frames is {}; an odd number, at least 1, was expected",
                                    options.averaged_frames));
  }
}

}  // namespace samara::identification
