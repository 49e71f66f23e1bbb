#pragma once

#include <optional>
#include <vector>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/solve/starts/attitude_guess.h"
#include "samara/models/interface/parametric_model.h"

/// Internal to identification/.
namespace samara::identification {

/// The polynomials from which rates are taken.
struct StartSmoothing {
  int degree = 4;
  int frames = 15;  ///< within the bandwidth
  /// Of an attitude that is free and was not measured.
  std::optional<AttitudeGuess> guess = {};
};

/// Start states of the segments of a motion, from the capture alone: what is measured is smoothed
/// (smoothing.h); states that were not measured are those with which the equations give the measured rates.
/// For example the velocity in body axes u follows from (x, y, z)' = R(q) u, and a rate of rotation from the
/// rate of an angle. States that no rate depends on stay in the middle of their boxes.
///
/// @param equations with the coordinates of the family free, in their order
/// @param shared values of the shared unknowns
/// @returns own unknowns, one vector per segment, within their boxes
std::vector<Eigen::VectorXd> states_from_frames(const models::ParametricModel& equations,
                                                const FitProblem& problem, const Motion& motion,
                                                const Eigen::VectorXd& shared,
                                                const StartSmoothing& smoothing);

}  // namespace samara::identification
