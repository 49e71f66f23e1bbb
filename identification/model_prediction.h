#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "samara/identification/fit_options.h"
#include "samara/identification/fit_result.h"
#include "samara/identification/trajectory_source.h"

namespace samara::identification {

/// What a fitted model says of a capture at other times, for example after the window that was fitted: from
/// the capture's own start, through the same mean of frames (FitOptions::averaged_frames).
///
/// @param options, result of the fit of `family`
/// @param capture its number in the result; of one segment
/// @param times s, of the capture, increasing, not before its start (CaptureFit::start) and half a mean
/// @param interval s, between frames, where they are means
/// @returns times x compared outputs (those of CaptureFit::residuals that are no attitude), offsets included;
///   NaN if there is no trajectory
/// @throws ArgumentError for a capture that is not in the result or of several segments.
Eigen::MatrixXd predict(const TrajectoryFamily& family, const FitOptions& options, const FitResult& result,
                        std::size_t capture, const Eigen::VectorXd& times, double interval = 0.0);

}  // namespace samara::identification
