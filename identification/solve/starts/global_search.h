#pragma once

#include <optional>
#include <vector>

#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to identification/; with design/release_search.cpp the only place that knows NLopt.
namespace samara::identification {

/// Searches the whole box of the shared unknowns for where a descent should begin. The cost of a point is
/// what is left when every segment chooses its own start state, segments not joined: over short segments that
/// has few valleys where the cost of whole captures has hundreds.
///
/// @param start shared and own unknowns around which segments look for their states
/// @param found its shared unknowns are the best of the search; untouched if no point had a trajectory
/// @returns what was done
/// @throws what a trajectory source throws
GlobalSearch search_box(const FitProblem& problem, std::vector<SegmentResidual>& residuals,
                        const GlobalOptions& options, const FitPoint& start, FitPoint& found);

}  // namespace samara::identification
