#pragma once

#include <map>
#include <memory>
#include <string>

#include "samara/models/integrators/integrate.h"
#include "samara/models/interface/model.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Trajectories by the reference integrator, with analytic sensitivities: slower than a codebook by orders of
/// magnitude, but without its error and with no time at which it ends.
namespace samara::models {

/// @param fixed values (SI) of parameters and initial values that the fit does not touch
/// @param box of the coordinates that are free
/// @throws ArgumentError as ParametricModel, for an empty box or an interval without length, and for
///   an interval that leaves a parameter's meaning.
std::unique_ptr<TrajectoryFamily> reference_trajectories(std::shared_ptr<const Model> model,
                                                         const std::map<std::string, double>& fixed,
                                                         const std::map<std::string, Interval>& box,
                                                         const IntegrateOptions& options = {});

}  // namespace samara::models
