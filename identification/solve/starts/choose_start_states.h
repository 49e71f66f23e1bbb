#pragma once

#include <vector>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/models/interface/parametric_model.h"

/// Internal to identification/.
namespace samara::identification {

/// Start states of all segments, for fits whose captures are cut into segments (first_point in fit.cpp), the shared
/// unknowns held at `point`. Captures smoothed in several ways give candidates (states_from_frames.h); each segment
/// keeps the one from which its own frames are met best. A segment that is met much worse than the others grows from
/// its first frames to all of them.
///
/// @param equations with the coordinates of the family free, in their order
/// @param residuals one per segment; scratch
/// @param point its own unknowns are replaced
/// @param also_point its own unknowns are candidates too
void choose_start_states(const models::ParametricModel& equations, const FitProblem& problem,
                         std::vector<SegmentResidual>& residuals, FitPoint& point, bool also_point = false);

/// The own unknowns of one segment alone, the shared ones held and joins ignored, by Levenberg and Marquardt.
/// @param own from where; where it ended afterwards
/// @param frames only the first so many are compared
/// @returns 1/2 sum rho; infinite where a residual or a slope is not finite at the start, as without a trajectory: it
///   ends where they are
double minimize_own(const FitProblem& problem, SegmentResidual& residual, const Eigen::VectorXd& shared,
                    Eigen::VectorXd& own, int frames, int max_iterations);

}  // namespace samara::identification
