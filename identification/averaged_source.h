#pragma once

#include <memory>
#include <vector>

#include "samara/identification/fit_problem.h"
#include "samara/identification/trajectory_source.h"

/// Internal to identification/.
namespace samara::identification {

/// Where a segment takes its trajectory from: the family at its times; where frames are means of several
/// (FitProblem::averaged_frames), each frame, but not the end of a joined segment, as the mean of the
/// family's values at the times behind it.
/// @param wanted indices of coordinates, as TrajectoryFamily::at()
std::unique_ptr<TrajectorySource> averaged_source(const TrajectoryFamily& family, const FitProblem& problem,
                                                  const Segment& segment, const std::vector<int>& wanted);

}  // namespace samara::identification
