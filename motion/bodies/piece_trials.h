#pragma once

#include <span>
#include <vector>

#include "samara/motion/database/motion_database.h"

namespace samara::motion {

/// A segment that is gone on with from the end of another one.
struct PieceTrial {
  Eigen::Index after = 0, with = 0;
};

/// Whether the next event is of the kind of `with`, as bodies would meet it: from the state at the end of `after` with
/// the coefficients of its run until that event is certain, then on a ramp to those of `with`.
/// @param ramp s, of the coefficients
/// @returns per trial 1 or 0
std::vector<char> try_pieces(const MotionDatabase& database, std::span<const PieceTrial> trials, double ramp);

}  // namespace samara::motion
