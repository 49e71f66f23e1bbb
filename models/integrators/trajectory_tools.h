#pragma once

#include <span>
#include <string>

#include "samara/models/integrate.h"

/// What all integrators do before and after their steps.
namespace samara::models {

/// @throws ArgumentError unless the times are finite, from 0 on, and do not decrease.
void check_times(std::span<const double> times);

/// @throws ArgumentError unless the step is positive and finite.
void check_step(double step);

/// @throws ArgumentError unless there is a step to take, and at most 2^53.
void check_max_steps(long max_steps);

/// A trajectory whose rows are all still NaN.
Trajectory unfilled_trajectory(std::span<const double> times, int state_count, int sensitivity_count);

/// One sentence from the reason in `result.message`, with the numbers.
std::string outcome_sentence(const Trajectory& result, double end);

bool all_finite(std::span<const double> values);

/// Steps of one length that lead exactly from one time to another.
struct EqualSteps {
  long count = 0;
  double length = 0.0;
};

/// As few equal steps as `step` allows, give or take round-off. Counts beyond all reason are cut at 2^62,
/// which no limit allows.
EqualSteps equal_steps(double from, double to, double step);

}  // namespace samara::models
