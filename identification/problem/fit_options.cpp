#include "samara/identification/problem/fit_options.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/limits.h"
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

// Fields go by the names that they have in a config.

void validate(const ComparisonOptions& compared) {
  if (compared.span) require_positive(*compared.span, "span");
  if (compared.stride) {
    require_positive(*compared.stride, "stride");
    if (!compared.span) throw ArgumentError("stride is set without span; the length of a span was expected");
  }
  for (const auto& [name, period] : compared.periods) {
    require(period == 0.0 || (period >= kSmallestInput && period <= kLargestInput),
            fmt::format("the period of \"{}\"", name), period,
            fmt::format("0, or {} to {}", kSmallestInput, kLargestInput));
  }
  require(compared.averaged_frames >= 1 && compared.averaged_frames % 2 == 1, "averaged_frames",
          compared.averaged_frames, "an odd number, at least 1,");
}

void validate(const LossOptions& loss) {
  require_positive(loss.length_scale, "loss.length_scale");
  require_positive(loss.attitude_scale, "attitude_scale");
  for (const auto& [output, scale] : loss.scales)
    require_positive(scale, fmt::format("the loss scale of \"{}\"", output));
}

void require_length(const std::string& what, const models::Interval& interval) {
  if (interval.width() > 0.0 && std::isfinite(interval.width())) return;
  throw ArgumentError(fmt::format("{} goes from {} to {}; an interval with a length was expected", what,
                                  interval.lower, interval.upper));
}

void validate(const UnknownOptions& unknowns) {
  for (const auto& [name, value] : unknowns.fixed)
    require(std::isfinite(value), fmt::format("the fixed value of \"{}\"", name), value, "a finite number");
  for (const auto& [name, interval] : unknowns.box)
    require_length(fmt::format("the box of \"{}\"", name), interval);
}

void validate(const MeasurementOptions& measurement) {
  if (measurement.delay) require_length("the range of the delay", *measurement.delay);
  for (const auto& [output, range] : measurement.gains) {
    const std::string what = fmt::format("the range of the gain of \"{}\"", output);
    require_length(what, range);
    if (!range.contains(0.0)) continue;
    throw ArgumentError(fmt::format(
        "{} goes from {} to {}, and with a gain of 0 nothing is measured; an interval without 0 was expected",
        what, range.lower, range.upper));
  }
}

void validate(const SegmentOptions& segments) {
  if (segments.length) require_positive(*segments.length, "segments.length");
  if (segments.stages.empty())
    throw ArgumentError("segments.stages is empty; one weight or more was expected");
  for (const double stage : segments.stages)
    require(stage >= kSmallestInput && stage <= kLargestInput, "a weight of segments.stages", stage,
            fmt::format("{} to {}", kSmallestInput, kLargestInput));
}

void validate(const StartOptions& starts) {
  constexpr int kMostStarts = 10000;
  require_at_least_one("starts", starts.count);
  require(starts.count <= kMostStarts, "starts", starts.count, fmt::format("at most {}", kMostStarts));
  require_at_least_one("global.budget", starts.global.budget);
  require_at_least_one("rounds", starts.rounds);
}

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

std::string gain_name(const std::string& output) {
  return fmt::format("gain of {}", output);
}

std::vector<std::string> measurement_names(const FitOptions& options) {
  std::vector<std::string> names;
  if (options.measurement.delay) names.emplace_back(kDelay);
  for (const auto& [output, range] : options.measurement.gains) names.push_back(gain_name(output));
  return names;
}

std::map<std::string, double> fixed_of_model(const FitOptions& options) {
  std::map<std::string, double> fixed = options.unknowns.fixed;
  for (const std::string& name : measurement_names(options)) fixed.erase(name);
  return fixed;
}

void validate(const FitOptions& options) {
  validate(options.compared);
  validate(options.loss);
  require_at_least_one("noise.rounds", options.noise.rounds);
  validate(options.unknowns);
  validate(options.priors);
  if (options.camera.scale) require_positive(*options.camera.scale, "camera.scale");
  if (options.camera.rotation) require_positive(*options.camera.rotation, "camera.rotation");
  validate(options.measurement);
  validate(options.segments);
  validate(options.starts);
  if (options.solver.step) require_positive(*options.solver.step, "step");
  require_at_least_one("max_iterations", options.solver.max_iterations);
  const int replicates = options.uncertainty.bootstrap.replicates;
  require(replicates == 0 || replicates >= 2, "bootstrap.replicates", replicates, "0, or 2 or more,");
  const int samples = options.uncertainty.posterior.samples;
  require(samples >= 0, "posterior.samples", samples, "0 or more");
}

}  // namespace samara::identification
