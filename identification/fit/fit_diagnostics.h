#pragma once

#include <string>
#include <vector>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/uncertainty.h"

/// Internal to identification/: what a fit may claim, by profile.h, identifiability.h and whiteness.h.
namespace samara::identification {

/// From the captures of the result.
void add_whiteness(FitResult& result);

/// Needs the coefficients of the result, and their covariance.
void add_identifiability(const FitProblem& problem, const Uncertainty& uncertainty, FitResult& result);

/// Minimises again with each coefficient held. Needs the coefficients of the result.
/// @param residuals one per segment, joined as at the optimum
/// @param point the optimum
/// @throws what a trajectory source throws
void add_profiles(const models::TrajectoryFamily& family, const FitProblem& problem,
                  const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                  const Uncertainty& uncertainty, int max_iterations, FitResult& result);

/// Draws from the posterior, and a warning where they are not to be relied on.
/// @param residuals one per segment, joined as at the optimum
void add_posterior(const models::TrajectoryFamily& family, const FitProblem& problem,
                   const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                   const Uncertainty& uncertainty, const FitOptions& options, FitResult& result);

/// What is wrong with the draws of a posterior that is not settled, the worst unknowns by name.
std::string describe_unsettled(const Posterior& posterior);

/// Profiles that say otherwise than the standard errors. Needs the profiles.
void add_profile_warnings(FitResult& result);

}  // namespace samara::identification
