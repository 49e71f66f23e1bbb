#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "samara/identification/capture.h"
#include "samara/identification/fit_options.h"
#include "samara/identification/fit_result.h"
#include "samara/identification/prediction_score.h"
#include "samara/identification/trajectory_source.h"

/// Short windows of measured motions, each with what came after it: coefficients are fitted to the windows of
/// some motions, and what follows the windows of others is predicted.
namespace samara::benchmarks::identification {

struct Window {
  samara::identification::Capture capture;  ///< what is measured and the labels of the motion; times from 0
  double next_time = 0.0;                   ///< s, in the window's times
  Eigen::RowVector3d next;                  ///< m, measured there
};

/// One after the other, from the first frame on.
/// @param frames of a window
/// @param ahead frames from its last one to the one that is predicted
std::vector<Window> cut(const samara::identification::Capture& motion, int frames, int ahead);

std::vector<samara::identification::Capture> captures_of(std::span<const Window> windows);

/// The same fit with all coefficients held at those of another: start states of windows that had no part in
/// it.
samara::identification::FitOptions with_coefficients(samara::identification::FitOptions options,
                                                     const samara::identification::FitResult& result);

/// Distances between prediction and measurement.
std::vector<double> model_errors(const samara::identification::TrajectoryFamily& family,
                                 const samara::identification::FitOptions& options,
                                 const samara::identification::FitResult& result,
                                 std::span<const Window> windows);
std::vector<double> baseline_errors(samara::identification::Baseline baseline,
                                    std::span<const Window> windows);

/// Root mean square distances between windows and the model inside them.
std::vector<double> window_misfits(const samara::identification::FitResult& result);

/// Standard errors of the logarithms of the coefficients: their scatter over fits to drops drawn with
/// replacement, each from the fit of all.
/// @param label of the captures, names the drop
std::map<std::string, double> bootstrap_errors(const samara::identification::TrajectoryFamily& family,
                                               samara::identification::FitOptions options,
                                               const samara::identification::FitResult& fitted,
                                               std::span<const Window> windows, const std::string& label,
                                               int repeats);

}  // namespace samara::benchmarks::identification
