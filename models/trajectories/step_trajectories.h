#pragma once

#include <map>
#include <memory>
#include <string>

#include "samara/models/interface/model.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Trajectories by Runge-Kutta steps of one length, with the exact derivatives of those steps: tens of times
/// faster than the reference integrator, for fits of short segments. The error of the steps is not estimated;
/// a fit says what the steps did to its coefficients (FitResult::integration_shift).
namespace samara::models {

/// @param fixed, box as reference_trajectories()
/// @param step s, an upper bound
/// @throws ArgumentError as reference_trajectories(), and if the step is not positive.
std::unique_ptr<TrajectoryFamily> step_trajectories(std::shared_ptr<const Model> model,
                                                    const std::map<std::string, double>& fixed,
                                                    const std::map<std::string, Interval>& box, double step);

}  // namespace samara::models
