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

/// @throws ArgumentError or InputError unless the capture measures what is compared, and has the labels of
/// what is known.
void check_capture(const Capture& capture, const FitOptions& options, const FitProblem& problem);

}  // namespace samara::identification
