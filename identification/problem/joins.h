#pragma once

#include "samara/identification/problem/fit_problem.h"

/// Internal to identification/: how unknowns move, and how segments hang together.
namespace samara::identification {

/// Charts of the shared and the own unknowns.
/// @throws ArgumentError for a logarithmic coordinate that is not shared or not positive.
void add_charts(const FamilyInfo& family, const FitOptions& options, FitProblem& problem);

/// @throws ArgumentError for a prior of what is not free or part of an attitude, for one outside its meaning,
/// and for a combination of what is not shared.
void add_priors(const FitOptions& options, FitProblem& problem);

/// Where the first start has the shared unknowns.
/// @throws ArgumentError for what is not shared, and for values outside the box.
void set_initial(const FitOptions& options, FitProblem& problem);

/// The rules by which segments follow one another, and the outputs they need.
/// @throws ArgumentError if a segment cannot start where the one before it ends, because a state is neither
///   free in each segment nor one that the motion does not depend on; if such a one is compared, it must be
///   free or have an offset.
void add_joins(const FamilyInfo& family, FitProblem& problem);

}  // namespace samara::identification
