#include "samara/identification/trajectories/trajectory_source.h"

namespace samara::identification {

std::unique_ptr<TrajectorySource> TrajectoryFamily::at(const std::vector<double>& times,
                                                       const std::vector<std::string>& outputs,
                                                       const std::vector<int>& /*wanted*/) const {
  return at(times, outputs);
}

}  // namespace samara::identification
