#pragma once

#include <string>

#include "samara/motion/ghost/ghost_force.h"
#include "samara/motion/planning/planner.h"

namespace samara::motion {

/// The page for the browser that `samara synthesize --report` writes, complete in one file as those of patterns and
/// fits are: the fall over its sketch, from the side (and from the other side), coefficients over time, kinds asked
/// and got, the invisible force, the parts of the cost, the history of the search, the plan.
std::string motion_html(const MotionPlan& plan, const MotionResult& motion, const GhostForce& ghost);

/// What `samara synthesize --json` prints, schema "samara-motion/1".
std::string motion_json(const MotionPlan& plan, const MotionResult& motion, const GhostForce& ghost);

}  // namespace samara::motion
