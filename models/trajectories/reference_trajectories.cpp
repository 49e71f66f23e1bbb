#include "samara/models/trajectories/reference_trajectories.h"

#include <utility>

#include "samara/models/trajectories/integrator_trajectories.h"
#include "samara/models/trajectories/model_family.h"

namespace samara::models {

std::unique_ptr<TrajectoryFamily> reference_trajectories(std::shared_ptr<const Model> model,
                                                         const std::map<std::string, double>& fixed,
                                                         const std::map<std::string, Interval>& box,
                                                         const IntegrateOptions& options) {
  require_free_coordinates(box);
  return integrator_trajectories(std::move(model), fixed, box, options);
}

}  // namespace samara::models
