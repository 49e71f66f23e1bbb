#pragma once

#include <vector>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Internal to identification/: whether frames are dense enough for trajectories to be shifted by a delay, which
/// is done by polynomials between times (delayed_source.h).
namespace samara::identification {

/// The largest difference, over the loss scale, of a compared output or an attitude shifted by the delay from
/// the family asked at the very time. 0 without a delay, and where there is no trajectory.
double delay_error(const models::TrajectoryFamily& family, const FitProblem& problem,
                   std::vector<SegmentResidual>& residuals, const FitPoint& point);

/// Warns where that is more than a hundredth of a loss scale.
void add_delay_warning(const models::TrajectoryFamily& family, const FitProblem& problem,
                       std::vector<SegmentResidual>& residuals, const FitPoint& point, FitResult& result);

}  // namespace samara::identification
