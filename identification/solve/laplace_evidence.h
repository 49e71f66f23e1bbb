#pragma once

#include <vector>

#include "samara/base/termination.h"
#include "samara/identification/problem/evidence.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to identification/.
namespace samara::identification {

/// The evidence of FitObjective::evidence().
/// @param residuals one per segment  @param answer where the minimum is looked for
Outcome<Evidence> laplace_evidence(const models::TrajectoryFamily& family, const FitProblem& problem,
                                   const std::vector<SegmentResidual>& residuals, const FitPoint& answer);

}  // namespace samara::identification
