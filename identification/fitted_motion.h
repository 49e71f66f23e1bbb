#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/fit_options.h"
#include "samara/identification/fit_result.h"
#include "samara/identification/trajectory_source.h"

namespace samara::identification {

/// What a fitted capture does at times at which there need be no frames: between them, or beyond.
/// @param family, options those of the fit
/// @param capture its number in `fitted.captures`
/// @param times s, not decreasing, since the capture's first segment began (its first frame)
/// @param outputs of the family
/// @returns times x outputs, SI, offsets included; empty where the family has no trajectory
/// @throws ArgumentError if there is no such capture or output
std::optional<Eigen::MatrixXd> fitted_motion(const TrajectoryFamily& family, const FitOptions& options,
                                             const FitResult& fitted, std::size_t capture,
                                             const std::vector<double>& times,
                                             const std::vector<std::string>& outputs);

}  // namespace samara::identification
