#pragma once

#include <span>
#include <string>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/solve/uncertainty.h"

/// Internal to identification/: warnings of the finished result of a fit. A check that looks at something else
/// adds its own where it is made; the kinds of all are in warnings.h.
namespace samara::identification {

/// Outputs, and the attitude, whose residuals are many times their loss scale. Needs the residuals over all captures.
void add_misfit_warnings(const FitProblem& problem, FitResult& result);

/// Segments whose starts could not be found, because the equations of the family are not known.
void add_start_warning(const models::TrajectoryFamily& family, const FitOptions& options, FitResult& result);

/// What is suspicious about the captures as such, what was done to them, and what in them means nothing to
/// the model.
void add_capture_warnings(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                          const FitOptions& options, FitResult& result);

/// Captures whose first frame became time 0 of equations that depend on time (Capture::start).
std::vector<std::string> moved_times(const models::FamilyInfo& family, std::span<const Capture> captures);

/// For a fit that led nowhere: captures that move far faster than a body of the model could.
void add_speed_warnings(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                        FitResult& result);

/// Of an answer that its prior all but rules out.
/// @param away deviations of the prior from its mean
void add_prior_warning(const std::string& what, double value, double away, Warnings& warnings);

/// What the reader must know: coefficients at bounds, far from their priors or not determined, errors that cannot be
/// trusted, other optima. Needs coefficients, captures and starts.
/// @param point the answer
void add_warnings(const FitProblem& problem, const FitPoint& point, const Uncertainty& uncertainty,
                  FitResult& result);

}  // namespace samara::identification
