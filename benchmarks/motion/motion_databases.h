#pragma once

#include "samara/motion/database/motion_database.h"

namespace samara::benchmarks::motion_cases {

/// The plate at I* 1.3 over three coefficients, from 0.6 rad.
motion::MotionDatabase planar_motions(int runs);

/// The card of the dissertation over three coefficients, so many of each, for `until` seconds: released by 10 degrees
/// about an axis aslant, and, unless it is to leave its plane, about its longer one as well.
motion::MotionDatabase card_motions(int count, double until, bool aslant_only = false);

}  // namespace samara::benchmarks::motion_cases
