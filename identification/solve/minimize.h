#pragma once

#include <string>
#include <vector>

#include "samara/base/termination.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to identification/; with ceres_terms.h the only place that knows Ceres' solver.
namespace samara::identification {

struct MinimizeResult {
  FitPoint point = {};
  Termination status = Termination::failed;  ///< or converged, max_iterations
  std::string message = {};
  double cost = 0.0;
  int iterations = 0;
};

/// How near to the minimum a descent ends. Where motions are not joined and have unknowns of their own, where
/// no step would move an unknown by more than a hundredth (rough: a tenth) of its naive standard error
/// (separable_descent.h); else where the cost changes by less than 1e-11 (rough: 1e-7) of itself. Where many
/// residuals are outliers those steps converge linearly only: at 1e-11 the coefficients stand still within a
/// thousandth of their standard errors.
enum class Precision { full, rough };

/// From one start to a minimum of 1/2 sum rho within the box.
/// @param residuals one per segment of the problem
/// @throws what a trajectory source throws
MinimizeResult minimize(const FitProblem& problem, std::vector<SegmentResidual>& residuals, FitPoint start,
                        int max_iterations, Precision precision = Precision::full);

}  // namespace samara::identification
