#pragma once

#include <vector>

#include "samara/motion/courses/coefficient_course.h"
#include "samara/motion/planning/fall_lanes.h"

namespace samara::motion {

/// A fall along knots, step by step.
struct ReplayedFall {
  std::vector<FallPoint> at_knots;  ///< where each knot begins
  FallPoint end;
  double cost = 0.0;  ///< fall_cost.h, of the whole
};

/// From `start` along the knots to the ground, or to the end of the time; not finite: the cost is infinite.
ReplayedFall replay(const PlannedFall& fall, const FallPoint& start, const std::vector<CourseKnot>& knots);

}  // namespace samara::motion
