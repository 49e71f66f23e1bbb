#pragma once

#include "samara/motion/planning/motion_plan.h"

/// What the database of a plan says against it, before anything is searched.
namespace samara::motion {

/// @throws ArgumentError for a pattern that is given, and that no fall of the database with coefficients in the plan's
/// box has: with the coefficients of the fall nearest to the box that has it
void require_patterns_in_box(const MotionPlan& plan);

/// By the motion graph of the database.
/// @throws ArgumentError for kinds that are given one after the other where no segment of the first kind leads to one
/// of the second, or patterns that follow each other where no way leads from a fall of one to a fall of the other
void require_ways(const MotionPlan& plan);

/// @throws ArgumentError for a sketch with times that rises faster than any fall of the database ever does, or, of a
/// body let go at rest, with a point above the release
void require_rise(const MotionPlan& plan);

}  // namespace samara::motion
