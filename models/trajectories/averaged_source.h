#pragma once

#include <memory>
#include <string>
#include <vector>

#include "samara/models/trajectories/trajectory_family.h"

/// Trajectories as a camera or a tracking program sees them that averages over frames: every frame is the
/// mean of the family's values at its own time and at those of its neighbours, and so are its derivatives.
namespace samara::models {

/// What a frame is the mean of.
struct FrameMean {
  int frames = 1;              ///< centred on it, odd
  double interval = 0.0;       ///< s, between them
  bool last_is_state = false;  ///< the last time is no frame: the end of a joined segment
};

/// @throws ArgumentError unless `mean.frames` is odd and positive and, of several, `mean.interval` positive.
void check_frame_mean(const FrameMean& mean);

/// The family's values where frames are single; else each frame as the mean of the family's values at
/// `mean.frames` times centred on it. Of these times, those before 0 count as 0, and those that
/// rounding puts after the end of the family as the end.
/// @param times s, since the start of the trajectory
/// @param outputs, wanted as TrajectoryFamily::at()
/// @throws as TrajectoryFamily::at()
std::unique_ptr<TrajectorySource> averaged_source(const TrajectoryFamily& family, const FrameMean& mean,
                                                  const std::vector<double>& times,
                                                  const std::vector<std::string>& outputs,
                                                  const std::vector<int>& wanted);

}  // namespace samara::models
