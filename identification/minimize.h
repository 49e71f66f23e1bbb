#pragma once

#include <string>
#include <vector>

#include "samara/identification/fit_problem.h"
#include "samara/identification/fit_result.h"
#include "samara/identification/segment_residual.h"

/// Internal to identification/; the only place that knows Ceres.
namespace samara::identification {

struct MinimizeResult {
  FitPoint point = {};
  FitStatus status = FitStatus::failed;
  std::string message = {};
  double cost = 0.0;
  int iterations = 0;
};

/// From one start to a minimum of 1/2 sum rho within the box.
/// @param residuals one per segment of the problem
/// @throws what a trajectory source throws
MinimizeResult minimize(const FitProblem& problem, std::vector<SegmentResidual>& residuals, FitPoint start,
                        int max_iterations);

}  // namespace samara::identification
