#pragma once

#include <string>
#include <vector>

#include "samara/identification/fit/capture_prediction.h"
#include "samara/identification/fit/motion_forecasts.h"
#include "samara/identification/fit/prediction.h"
#include "samara/identification/problem/fit_options.h"

/// Scores of predictions; internal to identification/.
namespace samara::identification {

std::vector<Quantity> quantities(const PredictedOutputs& predicted, const FitOptions& options);

/// s beyond the span, of the last frame of all.
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
