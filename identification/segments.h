#pragma once

#include <span>

#include "samara/identification/fit_problem.h"

/// Internal to identification/.
namespace samara::identification {

/// Cuts the captures to the window, keeps what is compared, and finds the clusters. `problem` has its outputs
/// already.
/// @throws ArgumentError as fit()
void add_segments(const FamilyInfo& family, std::span<const Capture> captures, const FitOptions& options,
                  FitProblem& problem);

}  // namespace samara::identification
