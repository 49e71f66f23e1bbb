#pragma once

#include <map>
#include <memory>
#include <string>

#include "samara/codebooks/book/codebook.h"
#include "samara/identification/trajectories/interval.h"
#include "samara/identification/trajectories/trajectory_source.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/interface/model.h"

/// Trajectories by the reference integrator, with analytic sensitivities: slower than a codebook by orders of
/// magnitude, but without its error and with no time at which it ends.
namespace samara::identification {

/// @param fixed values (SI) of parameters and initial values that the fit does not touch
/// @param box of the coordinates that are free
/// @throws ArgumentError as models::ParametricModel, for an empty box or an interval without length, and for
///   an interval that leaves a parameter's meaning.
std::unique_ptr<TrajectoryFamily> reference_trajectories(std::shared_ptr<const models::Model> model,
                                                         const std::map<std::string, double>& fixed,
                                                         const std::map<std::string, Interval>& box,
                                                         const models::IntegrateOptions& options = {});

/// What the codebook is a solution of, over the same box.
/// @throws ArgumentError if Samara has no model of that name.
std::unique_ptr<TrajectoryFamily> reference_trajectories(const codebooks::Codebook& book,
                                                         const models::IntegrateOptions& options = {});

}  // namespace samara::identification
