#include "samara/models/integrators/trajectory_tools.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "samara/base/errors.h"
#include "samara/base/number_text.h"
#include "samara/base/require.h"

namespace samara::models {

void check_times(std::span<const double> times) {
  double previous = 0.0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto refuse = [&](const std::string& expected) {
      throw ArgumentError("times[" + std::to_string(k) + "] is " + number_text(times[k]) + "; " + expected +
                          " was expected");
    };
    if (!std::isfinite(times[k])) refuse("a finite number");
    if (times[k] < previous)
      refuse(number_text(previous) + (k == 0 ? "" : " (the time before it)") + " or more");
    previous = times[k];
  }
}

void check_step(double step) {
  require_positive(step, "step");
}

void check_relative_tolerance(double relative_tolerance) {
  require(relative_tolerance > 0.0 && relative_tolerance < 1.0, "relative_tolerance", relative_tolerance,
          "a value between 0 and 1");
}

void check_max_steps(long max_steps) {
  require(max_steps >= 1, "max_steps", max_steps, "1 or more");
  if (max_steps > 1L << 53) {
    throw ArgumentError("max_steps is " + std::to_string(max_steps) + "; 2^53 or less was expected");
  }
}

Trajectory unfilled_trajectory(std::span<const double> times, int state_count, int sensitivity_count) {
  Trajectory result;
  result.status = IntegrateStatus::done;
  result.times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  result.states.setConstant(result.times.size(), state_count, std::numeric_limits<double>::quiet_NaN());
  result.sensitivities.assign(static_cast<std::size_t>(sensitivity_count), result.states);
  return result;
}

std::string outcome_sentence(const Trajectory& result, double end) {
  const std::string steps = std::to_string(result.steps) + " steps";
  if (result.is_usable()) return "reached t = " + number_text(end, 6) + " in " + steps;
  return "stopped at t = " + number_text(result.reached, 6) + " of " + number_text(end, 6) + " after " +
         steps + ": " + result.message;
}

bool all_finite(std::span<const double> values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

EqualSteps equal_steps(double from, double to, double step) {
  if (!(to > from)) return {};
  constexpr double kRoundOff = 1e-9;  // of a step: 0.3 is three steps of 0.1
  const double count = std::max(1.0, std::ceil((to - from) / step - kRoundOff));
  constexpr double kMostSteps = 0x1p62;  // still a long; infinity is not
  return {static_cast<long>(std::min(count, kMostSteps)), (to - from) / count};
}

}  // namespace samara::models
