#pragma once

#include "samara/identification/problem/fit_problem.h"

/// Internal to identification/: in which coordinates unknowns move, and where the shared ones begin.
namespace samara::identification {

/// Charts of the shared and the own unknowns.
/// @throws ArgumentError for a logarithmic coordinate that is not shared or not positive.
void add_charts(const models::FamilyInfo& family, const FitOptions& options, FitProblem& problem);

/// Where the first start has the shared unknowns: where the options say, else in the middle of the box.
/// @param problem with charts
/// @throws ArgumentError for what is not shared, and for values outside the box.
void set_initial(const FitOptions& options, FitProblem& problem);

}  // namespace samara::identification
