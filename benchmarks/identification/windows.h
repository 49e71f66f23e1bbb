#pragma once

#include <span>
#include <string>
#include <vector>

#include "real_data.h"
#include "samara/identification/captures/capture.h"
#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Short windows of measured motions, each with what came after it: coefficients are fitted to the windows of
/// some motions, and what follows the windows of others is predicted.
namespace samara::benchmarks::identification {

struct Window {
  samara::identification::Capture capture;  ///< what is measured and the labels of the motion; times from 0
  double next_time = 0.0;                   ///< s, in the window's times
  Eigen::RowVector3d next;                  ///< m, measured there
  int first = 0;                            ///< frame of the motion with which it begins
};

/// One after the other, from the first frame on.
/// @param frames of a window
/// @param ahead frames from its last one to the one that is predicted
/// @param stride frames from the start of one to the next; 0: as many as a window has
std::vector<Window> cut(const samara::identification::Capture& motion, int frames, int ahead, int stride = 0);

/// The same, each cleaned without what came after it; left out are those of which that leaves a frame unseen.
std::vector<Window> cut_as_known(const samara::identification::Capture& motion, int frames, int ahead,
                                 int stride = 0);

std::vector<samara::identification::Capture> captures_of(std::span<const Window> windows);

/// The same fit with all coefficients held, for the start states of windows that had no part in it.
samara::identification::FitOptions with_coefficients(samara::identification::FitOptions options,
                                                     const Coefficients& coefficients);

/// Where a fitted model is at the next time of each window [m]; infinite where it has no motion.
Eigen::MatrixX3d model_next(const samara::models::TrajectoryFamily& family,
                            const samara::identification::FitOptions& options,
                            const samara::identification::FitResult& result, std::span<const Window> windows);
Eigen::MatrixX3d baseline_next(samara::identification::Baseline baseline, std::span<const Window> windows);

/// Distances between prediction and measurement, m.
std::vector<double> errors_of(const Eigen::MatrixX3d& next, std::span<const Window> windows);
std::vector<double> baseline_errors(samara::identification::Baseline baseline,
                                    std::span<const Window> windows);

/// The baseline with the least median distance, of those that see places alone.
struct BestBaseline {
  std::string name = {};
  double median = 0.0;  ///< m
};
BestBaseline best_baseline(std::span<const Window> windows);

/// Start states of unseen windows with the coefficients of a fit, and the errors of what follows.
struct Prediction {
  samara::identification::FitResult fit;  ///< of the windows, coefficients held
  Eigen::MatrixX3d next = {};             ///< m
  std::vector<double> errors = {};        ///< m, distances from what was measured
};
Prediction predict_unseen(const samara::models::TrajectoryFamily& family,
                          const samara::identification::FitOptions& options, const Coefficients& coefficients,
                          std::span<const Window> unseen);

/// Root mean square distances between windows and the model inside them.
std::vector<double> window_misfits(const samara::identification::FitResult& result);

/// Each coefficient of a fit with its errors, a line on stderr.
void say_coefficients(const samara::identification::FitResult& result);

}  // namespace samara::benchmarks::identification
