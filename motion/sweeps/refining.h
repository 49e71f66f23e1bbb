#pragma once

#include <string>
#include <vector>

#include "samara/motion/sweeps/sweep.h"

namespace samara::motion {

/// A sweep before its first round, and after each.
struct RefiningRound {
  Eigen::Index points = 0;
  Eigen::Index run = 0;  ///< of them; the others inherited their labels
  /// Share of the points that came first of which the others that were run tell the pattern, of the release where they
  /// do so worst: later ones crowd at borders, and those that inherited have what their neighbours have.
  double agreement = 0.0;
};

struct RefiningResult {
  std::vector<RefiningRound> rounds;  ///< the sweep as it came first
  bool complete = false;              ///< false: cancelled; the rounds that are here are whole
  double seconds = 0.0;
  std::string message = "not run";  ///< why it ended
};

/// Rounds of refine() (pattern_map.h), as many as the plan has, or until one adds less than its `refine_gain` to the
/// agreement. @param sweep a finished one of the plan
/// @throws ArgumentError for fewer points than a map needs.
RefiningResult refine_by_plan(const SweepPlan& plan, const SweepOptions& options, Sweep& sweep);

}  // namespace samara::motion
