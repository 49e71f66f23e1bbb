#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/models/trajectories/trajectory_family.h"

namespace samara::identification {

/// What a fitted capture does at times at which there need be no frames: between them, or beyond. It starts
/// from the capture's own start, and goes through the same mean of frames (ComparisonOptions::averaged_frames).
/// @param family, options those of the fit
/// @param capture its number in `fitted.captures`
/// @param times s, of the capture, not decreasing, not before CaptureFit::start, less the delay of its clock, and
///   half a mean of frames
/// @param outputs of the family
/// @returns times x outputs, SI, gains and offsets included; empty where the family has no trajectory
/// @throws ArgumentError if there is no such capture or output
std::optional<Eigen::MatrixXd> fitted_motion(const models::TrajectoryFamily& family,
                                             const FitOptions& options, const FitResult& fitted,
                                             std::size_t capture, const std::vector<double>& times,
                                             const std::vector<std::string>& outputs);

}  // namespace samara::identification
