#pragma once

#include "samara/identification/problem/fit_problem.h"

/// Internal to identification/: how segments of one motion follow one another.
namespace samara::identification {

/// The rules by which segments follow one another, and the outputs they need.
/// @param problem with charts
/// @throws ArgumentError if a segment cannot start where the one before it ends, because a state is neither
///   free in each segment nor one that the motion does not depend on; if such a one is compared, it must be
///   free or have an offset.
void add_joins(const models::FamilyInfo& family, FitProblem& problem);

}  // namespace samara::identification
