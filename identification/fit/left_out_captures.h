#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/fit/capture_prediction.h"
#include "samara/identification/fit/prediction.h"
#include "samara/identification/fit/prediction_scores.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/warnings.h"

/// Captures that had no part in a fit, predicted by it; internal to identification/.
namespace samara::identification {

/// Captures left out of one fit, predicted by it.
struct PredictedCaptures {
  std::vector<Quantity> compared = {};
  std::vector<CapturePrediction> predictions = {};
  /// Why some could not be predicted, and which.
  std::vector<std::pair<std::string, std::vector<std::string>>> lacks = {};
  std::vector<std::string> sentences = {};  ///< what else the reader of the scores must know
  std::vector<std::string> shares = {};     ///< of mixtures, in sentences
  /// Spans all along the captures, of which the model was not asked; only where they are wanted.
  std::vector<CapturePrediction> along = {};

  void add_lack(const std::string& reason, const std::vector<std::string>& captures);
  /// What was said already is not said again.
  void add_sentences(const std::vector<std::string>& others);
  /// @param other of other clusters, which go on in number
  void add(PredictedCaptures other);
};

/// @throws ArgumentError for times outside their meaning, and for spans all along captures of a family whose equations
/// depend on time
void check_prediction(const models::FamilyInfo& family, const FitOptions& options,
                      const PredictionOptions& prediction);

/// @param captures that are predicted, or teach predictions
/// @throws ArgumentError for one without a channel of a view, and for views where no place in space is predicted
void check_views(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                 const FitOptions& options, const PredictionOptions& prediction);

/// @param whole, file, checksum of a capture that is fitted, in part or all: its table is known by its bytes, and
///   by the name of the file where the fit does not tell them
/// @throws InputError where it, or a part of it, is among those left out
void refuse_fitted(const std::string& whole, const std::string& file, const std::string& checksum,
                   std::span<const Capture> left_out);

/// @param wants_along whether spans all along the captures are wanted
PredictedCaptures look_ahead(const models::TrajectoryFamily& family, const FitResult& fitted,
                             std::span<const Capture> left_out, const FitOptions& options,
                             const PredictionOptions& prediction, bool wants_along = false);

/// Where predictions end before what was asked for, in one sentence; empty: they do not.
/// @param source of trajectories, such as "codebook"
std::string shortfall(const std::vector<CapturePrediction>& predictions, const std::string& source,
                      const PredictionOptions& prediction);

/// What the reader must know of those that were predicted, and of those that were not.
void add_sentences(PredictedCaptures& outcome, Warnings& warnings);

}  // namespace samara::identification
