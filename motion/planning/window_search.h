#pragma once

#include <vector>

#include "samara/base/progress.h"
#include "samara/motion/planning/beam_search.h"

namespace samara::motion {

/// A fall along knots, step by step.
struct ReplayedFall {
  std::vector<FallPoint> at_knots;  ///< where each knot begins
  FallPoint end;
  double cost = 0.0;  ///< as of the beam, of the whole
};

/// From `start` along the knots to the ground, or to the end of the time; not finite: the cost is infinite.
ReplayedFall replay(const PlannedFall& fall, const FallPoint& start, const std::vector<CourseKnot>& knots);

/// Moves the coefficients at the knots: Gauss and Newton's method over windows of six knots that look ten knots ahead, one
/// window after another down the fall, within the box, with the exact tangents of the steps. Knots are first put at the
/// thirds of long pieces. A window is taken if it improves what it looks at, a sweep if it improves the whole.
/// @returns the fall with its knots, not worse than `found`
FoundFall refine_in_windows(const PlannedFall& fall, const FallPoint& start, const FoundFall& found,
                            const ProgressCallback& progress, std::vector<PlanningStep>& history);

}  // namespace samara::motion
