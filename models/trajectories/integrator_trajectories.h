#pragma once

#include <map>
#include <memory>
#include <string>
#include <variant>

#include "samara/models/integrators/adaptive.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/integrators/lie_group.h"
#include "samara/models/integrators/rk4.h"
#include "samara/models/integrators/rkmk.h"
#include "samara/models/interface/model.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Trajectories of a model by any integrator: which one, its options say.
///
///   const auto family = integrator_trajectories(model, fixed, {}, RkmkOptions{.step = 1e-3});
///   const FamilyTrajectory one = trajectory(*family, {}, times, output_names(family->info()));
///
/// Derivatives are those of CVODES alone: families of the others have values only
/// (FamilyInfo::has_derivatives). Runge-Kutta steps with derivatives: step_trajectories.h.
namespace samara::models {

/// LieGroupOptions are for models of one rigid body (lie_group_model.h).
using IntegratorChoice =
    std::variant<IntegrateOptions, AdaptiveOptions, Rk4Options, RkmkOptions, LieGroupOptions>;

/// @param fixed values (SI) of parameters and initial values that are held
/// @param box of the coordinates that are free; may be empty, for the one trajectory of `fixed`
/// @throws ArgumentError as ParametricModel, for an interval without length or one that leaves a parameter's
///   meaning, and as the integrator for its options.
std::unique_ptr<TrajectoryFamily> integrator_trajectories(std::shared_ptr<const Model> model,
                                                          const std::map<std::string, double>& fixed,
                                                          const std::map<std::string, Interval>& box,
                                                          const IntegratorChoice& integrator);

}  // namespace samara::models
