#pragma once

#include <span>
#include <string>
#include <vector>

#include "samara/models/integrators/integrate.h"

/// What all integrators do before and after their steps.
namespace samara::models {

/// @throws ArgumentError unless the times are finite, from 0 on, and do not decrease.
void check_times(std::span<const double> times);

/// @throws ArgumentError unless the step is positive and finite.
void check_step(double step);

/// @throws ArgumentError unless it lies between 0 and 1.
void check_relative_tolerance(double relative_tolerance);

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

/// As few equal steps as `step` allows, give or take round-off. Counts are at most 2^62, which exceeds
/// every limit.
EqualSteps equal_steps(double from, double to, double step);

/// The trajectory of a method with fixed steps, four evaluations of f each.
/// @param x the states at t = 0, which `advance` moves
/// @param advance advance(t, steps): from t by steps.count steps of steps.length
template <class Advance>
Trajectory fixed_step_trajectory(std::span<const double> times, double step, long max_steps,
                                 const std::vector<double>& x, const Advance& advance) {
  Trajectory result = unfilled_trajectory(times, static_cast<int>(x.size()), 0);
  double t = 0.0;
  for (Eigen::Index row = 0; row < result.times.size(); ++row) {
    const EqualSteps steps = equal_steps(t, result.times[row], step);
    if (steps.count > max_steps - result.steps) {
      result.status = IntegrateStatus::too_many_steps;
      result.message = "the next time takes more steps than allowed";
      break;
    }
    advance(t, steps);
    result.steps += steps.count;
    if (!all_finite(x)) {
      result.status = IntegrateStatus::not_finite;
      result.message = "the states are not finite at the next time asked for";
      break;
    }
    t = result.times[row];
    result.states.row(row) = Eigen::Map<const Eigen::RowVectorXd>(x.data(), result.states.cols());
  }
  result.reached = t;
  result.rhs_evaluations = 4 * result.steps;
  result.message = outcome_sentence(result, times.empty() ? 0.0 : times.back());
  return result;
}

}  // namespace samara::models
