#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/captures/capture.h"
#include "samara/identification/following/follower.h"
#include "samara/identification/forecasts/forecast_band.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/warnings.h"
#include "samara/models/interface/model.h"

/// Captures followed with what a fit found (follower.h).
///
///     const FollowOptions options = follow_options(*model, fitted, capture);
///     const FollowedMotion motion = follow(model, options, capture);
namespace samara::identification {

/// What a fit says of a motion that it has not seen: outputs and their noise (its noise levels, else what its residuals
/// leave), what was held, coefficients with their errors (by factors where their box is positive), where each capture's
/// own unknowns may lie (priors, else their boxes). Errors and correlations of coefficients are those of frames as
/// independent; errors of the scatter between clusters, where that is more than chance. Coefficients without an error
/// may lie anywhere in their boxes. Those at a bound, and initial values that captures share, are held. Model noise and
/// drifts are zero: choose_noise() finds them.
/// @param capture has the values of what is known for each capture; outputs it does not measure are left out
/// @throws ArgumentError or InputError for a fit that failed, with delay, gains (but those held at 0 and 1), or offsets
/// of what is no place; for a capture that lacks a known value or all outputs; if an output has neither a noise nor a
/// residual; and for coefficients outside their boxes or with errors that are not positive and finite
FollowOptions follow_options(const models::Model& model, const FitResult& fitted, const Capture& capture);

/// Names the coefficients of which follow_options() takes no error from the fit: those that it holds, and those that
/// may lie anywhere in their boxes.
Warnings warnings_of_coefficients(const models::Model& model, const FitResult& fitted);

/// A capture, frame by frame. Tables have a row for each frame; NaN before the start was found.
struct FollowedMotion {
  std::string capture = {};             ///< its id
  std::vector<std::string> names = {};  ///< of columns: the states of the model, then the coefficients
  std::vector<std::string> units = {};
  Eigen::VectorXd times = {};        ///< s, of frames
  Eigen::VectorXd state_times = {};  ///< s, of states: half a mean of frames earlier
  std::vector<FollowedFrame> frames = {};
  /// SI; the most likely hypothesis after the frame, and standard errors.
  Eigen::MatrixXd values = {}, errors = {};
  /// The same in the light of all frames; NaN for frames that were not followed.
  Eigen::MatrixXd smoothed_values = {}, smoothed_errors = {};
  double log_likelihood = 0.0;  ///< of all frames after starts, each before it was seen
  /// Of each frame, what would be measured `ahead` seconds later of outputs: as Follower::forecast(), with a band of
  /// 90 %. No columns if it was not asked for.
  double ahead = 0.0;
  std::vector<std::string> outputs = {}, output_units = {};
  ForecastBand forecasts = {};
};

/// Values of a frame in the order of Follower::measured(), NaN where the capture has no such channel, and for all of an
/// attitude of which a part is missing.
/// @throws as refuse() if it measures none of them, or one in a unit of another dimension
Eigen::MatrixXd frames_of(const Follower& follower, const models::ModelInfo& info, const Capture& capture);

/// A frame of a capture as Follower::add() takes it.
/// @param values as frames_of() gives them
/// @throws as refuse(), where Follower::add() refuses the frame
FollowedFrame add_frame(Follower& follower, const Capture& capture, const Eigen::MatrixXd& values,
                        Eigen::Index row);

/// @param ahead s, of the forecast beyond each frame
/// @throws ArgumentError if these are more than 1e10 steps, which take an hour
void check_steps(const FollowOptions& options, const Capture& capture, double ahead);

/// @param ahead s; 0: no forecasts
/// @throws ArgumentError as Follower, and for a time ahead that is negative; as add_frame()
FollowedMotion follow(std::shared_ptr<const models::Model> model, const FollowOptions& options,
                      const Capture& capture, double ahead = 0.0);

}  // namespace samara::identification
