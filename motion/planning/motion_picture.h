#pragma once

#include <string>

#include "samara/motion/ghost/ghost_force.h"
#include "samara/motion/planning/planner.h"

namespace samara::motion {

/// The path over its sketch, from the side (and, in space, from the other side), the coefficients over time, each
/// within its range, and the sizes of the invisible force, as SVG.
std::string motion_picture(const MotionPlan& plan, const MotionResult& motion, const GhostForce& ghost);

}  // namespace samara::motion
