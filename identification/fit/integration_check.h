#pragma once

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/uncertainty.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Internal to identification/.
namespace samara::identification {

/// What the length of the steps does to the coefficients: to first order the minimum moves by
///
///     H^-1 (g(h) - g(h/2)),
///
/// g the gradient of the cost with steps of length h, own unknowns eliminated, H the information at the
/// minimum. Nothing where the family has no finer one. Warns above a tenth of a standard error.
/// @param residuals evaluated at `point`, with derivatives
void add_integration_shift(const models::TrajectoryFamily& family, const FitProblem& problem,
                           const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                           const Uncertainty& uncertainty, FitResult& result);

}  // namespace samara::identification
