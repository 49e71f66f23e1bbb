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

/// Where many residuals are outliers the steps converge linearly only. At a relative change of the cost of
/// 1e-11 the coefficients stand still within a thousandth of their standard errors.
inline constexpr double kStandstill = 1e-11;

/// From one start to a minimum of 1/2 sum rho within the box.
/// @param residuals one per segment of the problem
/// @param tolerance relative change of the cost below which it ends
/// @throws what a trajectory source throws
MinimizeResult minimize(const FitProblem& problem, std::vector<SegmentResidual>& residuals, FitPoint start,
                        int max_iterations, double tolerance = kStandstill);

}  // namespace samara::identification
