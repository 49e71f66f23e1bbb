#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/captures/capture.h"
#include "samara/identification/fit/prediction.h"
#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/models/trajectories/trajectory_family.h"

/// One capture that was left out of a fit; internal to identification/.
namespace samara::identification {

/// What is predicted of captures.
struct PredictedOutputs {
  std::vector<models::FamilyOutput> outputs = {};  ///< with a value a frame
  std::vector<std::string> attitude = {};          ///< the outputs of a quaternion; empty: none
};

class MotionForecasts;

/// What was seen, what followed, and what the model made of it.
struct CapturePrediction {
  std::string file = {}, motion = {};  ///< of the capture, also of its spans: its file and id
  std::string part = {};               ///< id of the capture, or of the span
  int cluster = 0;                     ///< motions that may resemble each other have the same
  SeenMotion seen = {};
  SeenTurn turn = {};                      ///< empty where no attitudes are predicted
  Eigen::VectorXd times = {};              ///< since the first frame
  Eigen::MatrixXd truth = {}, model = {};  ///< NaN where missing, or where the model failed
  Eigen::MatrixX4d truth_attitude = {}, model_attitude = {};  ///< likewise
  bool is_cut = false;       ///< frames ahead lie beyond the end of trajectories
  std::string lack = {};     ///< why nothing can be compared; empty: it can
  std::string failure = {};  ///< why the model says nothing; empty: it does
  /// What other captures showed of every predictor; null: nothing is known of errors.
  std::shared_ptr<const MotionForecasts> trained = {};
};

/// Fits what is the capture's own to its span, and carries the model on.
/// @param options of a fit with the coefficients held; known coordinates of which the capture has no value
///   are unknowns of its own
/// @param asks_model whether the model is asked: else only what was seen and what followed is told
CapturePrediction predict_capture(const models::TrajectoryFamily& family, const Capture& capture,
                                  const PredictedOutputs& predicted, const FitOptions& options,
                                  const PredictionOptions& prediction, bool asks_model = true);

}  // namespace samara::identification
