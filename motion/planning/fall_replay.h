#pragma once

#include <functional>
#include <span>
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

/// What is seen of a fall: time and state of the start and after each step.
using SeenSteps = std::function<void(double t, std::span<const double> state)>;

/// From `start` along the knots to the ground, or to the end of the time; not finite: the cost is infinite. One that
/// does neither ends after four times as long as the plan says it takes, or after its last knot.
ReplayedFall replay(const PlannedFall& fall, const FallPoint& start, const std::vector<CourseKnot>& knots,
                    const SeenSteps& see = {});

}  // namespace samara::motion
