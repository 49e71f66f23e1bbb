#pragma once

#include "samara/codebooks/source/checkpoint.h"
#include "samara/motion/sweeps/sweep_file.h"

/// The kind of checkpoint that sweeps leave.
namespace samara::motion {

inline constexpr codebooks::CheckpointKind kSweepCheckpoint = {"a sweep", is_sweep_checkpoint};

}  // namespace samara::motion
