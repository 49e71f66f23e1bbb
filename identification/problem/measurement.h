#pragma once

#include <string>
#include <vector>

#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_problem.h"

/// Internal to identification/: what is not known of the clock of a capture and of the sensors that measured it.
/// Delay and gains are coordinates like those of the model, and stand after them: shared or own, held or known,
/// with boxes, priors and starts.
namespace samara::identification {

/// The delay and the gains that the options ask for, with their ranges.
std::vector<models::FamilyCoordinate> measurement_coordinates(const FitOptions& options);

/// The family with the delay and the gains that the options ask for among its coordinates.
/// @throws ArgumentError where the model has a coordinate of that name.
models::FamilyInfo with_measurement(const models::FamilyInfo& family, const FitOptions& options);

/// Which coordinates are delay and gains.
/// @param problem with coordinates, outputs and camera
/// @throws ArgumentError for the gain of what is not compared, or of what the camera scales, and for a delay of
/// spans.
void add_measurement(const FitOptions& options, FitProblem& problem);

/// s: where the delay of a motion may lie; without a width where it is held or known. {0, 0} if there is none.
models::Interval delay_range(const FitProblem& problem, const Motion& motion);

/// @param frames s since the start of a segment: the first and the last time that its frames, as means, reach
/// @throws ArgumentError or InputError where the delay may lead from there to a time before the start, or after
/// the end of the family.
void check_delay(const models::FamilyInfo& family, const FitProblem& problem, const Motion& motion,
                 const models::Interval& frames, double rounding);

/// At a point of the family with delay and gains: the delay, 0 if there is none, and the gain of a compared
/// output, 1 if it has none.
double delay_at(const FitProblem& problem, const Eigen::VectorXd& q);
double gain_at(const ComparedOutput& output, const Eigen::VectorXd& q);

/// Whether an own unknown belongs to the measurement, not to the motion: the camera's, a delay or a gain. One
/// segment of a motion alone hardly determines it.
bool is_of_measurement(const FitProblem& problem, int own);

}  // namespace samara::identification
