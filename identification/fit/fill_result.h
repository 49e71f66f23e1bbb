#pragma once

#include <span>
#include <vector>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/uncertainty.h"

/// Internal to identification/: putting the numbers of a fit into its result.
namespace samara::identification {

/// FitResult::setup.
void add_setup(const models::FamilyInfo& family, const FitProblem& problem, const FitOptions& options,
               FitResult& result);

void add_coefficients(const FitProblem& problem, const FitPoint& point, const Uncertainty& uncertainty,
                      FitResult& result);

/// @param residuals evaluated at `point`
void add_captures(const FitProblem& problem, const std::vector<SegmentResidual>& residuals,
                  const FitPoint& point, const Uncertainty& uncertainty, FitResult& result);

}  // namespace samara::identification
