#pragma once

#include <vector>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to identification/.
namespace samara::identification {

/// Start number `index` of a fit, the same in every run. The first is the centre of the box, with the values that
/// the options state for shared coordinates ([starts] initial, or another fit); then come Halton points in its
/// inner four fifths, in logarithms where those are fitted; all captures at the same values of their own
/// coordinates. Attitudes are made unit quaternions, and the first start has those first measured. Offsets
/// put each capture's mean residual to zero.
/// @param residuals one per segment; scratch
FitPoint start_point(const FitProblem& problem, std::vector<SegmentResidual>& residuals, int index);

}  // namespace samara::identification
