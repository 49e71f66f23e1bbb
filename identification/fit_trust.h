#pragma once

#include "samara/identification/fit_problem.h"
#include "samara/identification/fit_result.h"
#include "samara/identification/trajectory_source.h"
#include "samara/identification/uncertainty.h"

/// Internal to identification/: what a fit may claim, by profile.h, identifiability.h and whiteness.h.
namespace samara::identification {

/// From the captures of the result.
void add_whiteness(FitResult& result);

/// Needs the coefficients of the result, and their covariance.
void add_identifiability(const Uncertainty& uncertainty, FitResult& result);

/// Minimises again with each coefficient held. Needs the coefficients of the result.
/// @param point the optimum
/// @returns trajectories computed
/// @throws what a trajectory source throws
long add_profiles(const TrajectoryFamily& family, const FitProblem& problem, const FitPoint& point,
                  const Uncertainty& uncertainty, int max_iterations, FitResult& result);

/// Profiles that say otherwise than the standard errors. Needs the profiles.
void add_profile_warnings(FitResult& result);

}  // namespace samara::identification
