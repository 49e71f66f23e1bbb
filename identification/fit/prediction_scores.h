#pragma once

#include <string>
#include <vector>

#include "samara/identification/fit/capture_prediction.h"
#include "samara/identification/fit/motion_forecasts.h"
#include "samara/identification/fit/prediction.h"
#include "samara/identification/problem/fit_options.h"

/// Scores of predictions; internal to identification/.
namespace samara::identification {

/// @param held options of a fit with its coefficients held
std::vector<Quantity> quantities(const models::TrajectoryFamily& family, const PredictedOutputs& predicted,
                                 const FitOptions& held);

/// m/s^2: what a body weighs under water or in air, by its mass; that of the family's densities (or of its mass and
/// the mass that it displaces) where both are held, else all of g. Mass that the fluid adds is not counted.
double net_weight(const models::TrajectoryFamily& family, const FitOptions& held);

/// Whether the last frame lies near the end of the way, so that its distance counts as one there.
bool reaches_end(const CapturePrediction& one, const PredictionOptions& prediction);

/// s beyond the span, of the last frame of all; all of the way where one reaches its end.
double reach_of(const std::vector<CapturePrediction>& predictions, const PredictionOptions& prediction);

/// Scores of all captures together, and of each.
struct Scores {
  std::vector<PredictionScore> all = {}, by_capture = {};
};
Scores scores_of(const std::vector<Quantity>& compared, std::vector<CapturePrediction> predictions,
                 const PredictionOptions& prediction);

/// What every predictor is off at the end, of each that reaches it.
std::vector<ForecastError> forecast_errors(const std::vector<Quantity>& compared,
                                           std::vector<CapturePrediction> predictions,
                                           const PredictionOptions& prediction);

}  // namespace samara::identification
