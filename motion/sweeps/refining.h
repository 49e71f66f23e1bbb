#pragma once

#include <string>
#include <vector>

#include "samara/motion/sweeps/sweep.h"

namespace samara::motion {

/// A round of more points where they tell most, appended to the sweep.
///
/// Of a grid: the grid with twice as many intervals. A new point inherits the label where all corners of its old cell,
/// face or edge have the same for every release (status `inherited`; its features are not known), else its falls are
/// run. Of drawn points: a fifth more of them, where the nearest seven disagree most.
/// @returns false if cancelled; then the sweep is as it was
bool refine(const SweepPlan& plan, const SweepOptions& options, Sweep& sweep);

struct RefiningResult {
  std::vector<RefiningRound> rounds;  ///< the sweep as it came first, and after each round: Sweep::rounds
  bool complete = false;              ///< false: cancelled; the rounds that are here are whole
  double seconds = 0.0;
  std::string message = "not run";  ///< why it ended
};

/// Rounds of refine(), as many as the plan has, or until one adds less than its `refine_gain` to the
/// agreement. A sweep that has some of them goes on after the last, to the same points and labels. Each is kept in the
/// checkpoint of the options, which is removed when all is done.
/// @param sweep a finished one of the plan
/// @throws ArgumentError for fewer points than a map needs; InputError for another file in place of the checkpoint.
RefiningResult refine_by_plan(const SweepPlan& plan, const SweepOptions& options, Sweep& sweep);

}  // namespace samara::motion
