#pragma once

#include <span>
#include <string>
#include <vector>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/warnings.h"

/// Internal to identification/.
namespace samara::identification {

/// Cuts the captures to the span, keeps what is compared, and finds the clusters. `problem` has its outputs
/// already.
/// @throws ArgumentError as fit()
void add_segments(const models::FamilyInfo& family, std::span<const Capture> captures,
                  const FitOptions& options, FitProblem& problem);

/// Of frames that are means of several: initial values that are fixed, known, shared or have a prior, which belong to a
/// time before the first frame. What an offset of each capture takes up does not count, nor do turns about the axis of
/// a round body.
Warnings warnings_of_early_starts(const models::FamilyInfo& family, std::span<const Capture> captures,
                                  const FitOptions& options);

/// @throws ArgumentError or InputError unless the capture measures it, in its unit, in every frame or NaN.
const Channel& compared_channel(const Capture& capture, const std::string& name, const std::string& unit);

/// @throws ArgumentError or InputError unless the capture measures what is compared.
void check_capture(const Capture& capture, const FitProblem& problem);

/// Numbers of the clusters of captures, in the order in which they appear.
/// @throws ArgumentError if a capture lacks a label
std::vector<int> clusters_of(std::span<const Capture> captures, const std::vector<std::string>& cluster_by);

}  // namespace samara::identification
