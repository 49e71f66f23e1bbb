#pragma once

#include "samara/motion/planning/fall_lanes.h"
#include "samara/motion/planning/planner.h"

namespace samara::motion {

/// Events of a motion as it came out, by one finder from its release to its end; none where no kinds are asked for.
EventList events_of_motion(const PlannedFall& fall, const RealisedFall& real);

/// Fills in what the motion is: its states, how near it came, which kinds it has, and the status with its sentence. The
/// first of these that is so: lost, not landed, landed early, deviation missed, kinds missed, found.
void judge_motion(const PlannedFall& fall, const RealisedFall& real, MotionResult& result);

}  // namespace samara::motion
