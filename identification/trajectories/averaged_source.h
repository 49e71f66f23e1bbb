#pragma once

#include <memory>
#include <string>
#include <vector>

#include "samara/identification/trajectories/trajectory_source.h"

/// Internal to identification/.
namespace samara::identification {

/// What a frame is the mean of.
struct FrameMean {
  int frames = 1;              ///< centred on it, odd
  double interval = 0.0;       ///< s, between them
  bool last_is_state = false;  ///< the last time is no frame: the end of a joined segment
};

/// Where a segment takes its trajectory from: the family at its times; where frames are means of several,
/// each frame as the mean of the family's values at the times behind it.
/// @param times s, since the segment's start
/// @param outputs, wanted as TrajectoryFamily::at()
std::unique_ptr<TrajectorySource> averaged_source(const TrajectoryFamily& family, const FrameMean& mean,
                                                  const std::vector<double>& times,
                                                  const std::vector<std::string>& outputs,
                                                  const std::vector<int>& wanted);

}  // namespace samara::identification
