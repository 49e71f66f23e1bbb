#pragma once

#include "samara/identification/problem/fit_problem.h"

/// Internal to identification/: in which coordinates unknowns move.
namespace samara::identification {

/// Charts of the shared and the own unknowns.
/// @throws ArgumentError for a logarithmic coordinate that is not shared or not positive.
void add_charts(const models::FamilyInfo& family, const FitOptions& options, FitProblem& problem);

}  // namespace samara::identification
