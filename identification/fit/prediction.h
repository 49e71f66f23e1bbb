#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/report/read_fit.h"
#include "samara/models/trajectories/trajectory_family.h"

/// How well fitted coefficients predict captures that were left out of the fit.
///
/// Of each such capture the first `span` seconds are seen, attitudes too if the fit compared them: its own
/// unknowns (initial values, offsets, and known coordinates of which it has no value) are fitted there with
/// the coefficients held, and the model is carried on. Baselines (forecasts/baseline_scores.h) see the same span.
/// Compared are the frames that follow, up to `ahead` seconds after the span.
///
///     const FitResult result = fit(*family, training, options);
///     const auto scores = predict_left_out(*family, result, test, options, {.span = 0.2, .ahead = 0.1});
namespace samara::identification {

/// The same thing as two cameras show it: channels of captures, of one unit.
struct ViewPair {
  std::string along_first = {};   ///< as seen along the first level axis, x
  std::string along_second = {};  ///< as seen along the second one, y
  bool operator==(const ViewPair&) const = default;
};

struct PredictionOptions {
  double span = 0.0;   ///< s of each capture that are seen, from its first frame
  double ahead = 0.0;  ///< s beyond it
  /// s: from the start of one span to the next along each capture, each with what follows it (spans() in
  /// capture.h). Empty: one span.
  std::optional<double> stride = {};
  /// Of UnknownOptions::known, what captures left out do not show, though they may have it: unknowns of their
  /// own there, in their boxes and with their priors.
  std::vector<std::string> hidden = {};
  /// Whether forecasts are distributions, and predictors are mixed: with the errors, shares and weights that the
  /// captures of the fit show when each third of their clusters (or half of two) is predicted by a fit of the
  /// others. Adds predictors "mixture of baselines", "autoregression" and "mixture" (trained_forecasts.h).
  bool mixture = false;
  /// What cameras show of a body besides its place, such as sizes and shapes of its silhouette: the autoregression of a
  /// place x, y, z may look at it (SeenMotion::views). Every capture has these channels; NaN where it does not show
  /// them. Needs `mixture`.
  std::vector<ViewPair> views = {};
};

/// Parts of about equal size, of clusters of captures.
struct Folds {
  int count = 5;  ///< 2 to the number of clusters
  /// Clusters are dealt in random order. Empty: in their own.
  std::optional<std::uint64_t> seed = {};
};

/// Scores of the model and of every baseline, for each quantity that was fitted or is measured besides: outputs that
/// are lengths together, as the distance in space ("position"), velocities and rates likewise ("velocity", "angular
/// velocity"), the attitude by the angle of the turn between; every other output by itself. For each, two scores:
/// over all frames ahead ("position, up to 0.1 s ahead"; less where no capture goes so far), and of the last one,
/// within the last tenth of the way ("position, 0.1 s ahead"). Captures that have too few frames in the span or none
/// beyond are left out of all scores; those on which the fit of the span fails, of the model's. A score that no
/// capture counts for is left out. After the scores of all captures follow those of each.
/// @param fitted made by fit() or by read_fit(); its coefficients are held at their values, unless `options`
///   makes them each capture's own
/// @param options of that fit; span, starts and roles of what is not held are taken over
/// @returns nothing if the fit failed
/// @throws ArgumentError as fit(), for a capture that does not measure what was fitted or has no channel of a view, for
/// views where x, y and z are not all predicted, and for times that are not positive; InputError for a capture of a
/// file that was fitted itself.
std::vector<PredictionScore> predict_left_out(const models::TrajectoryFamily& family, const FitResult& fitted,
                                              std::span<const Capture> left_out, const FitOptions& options,
                                              const PredictionOptions& prediction);

/// The same into the result: scores into `predictions`, and sentences into `warnings` about captures that
/// could not be predicted (one for each reason), or not by the model, or not so far ahead.
/// @param training the captures of the fit; needed for a mixture
/// @throws ArgumentError for a mixture with fewer than two clusters of training captures
void add_predictions(const models::TrajectoryFamily& family, std::span<const Capture> left_out,
                     const FitOptions& options, const PredictionOptions& prediction, FitResult& fitted,
                     std::span<const Capture> training = {});

/// The same by cross validation: clusters of captures are dealt into folds, and those of each fold predicted
/// by a fit of all others (without profiles, bootstrap and posterior). Scores are those of all captures
/// together. With a mixture, the others of each fold train it.
/// @throws ArgumentError as fit() and predict_left_out(), and for folds without a cluster
void cross_validate(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                    const FitOptions& options, const PredictionOptions& prediction, const Folds& folds,
                    FitResult& fitted);

/// How far a forecast of a capture left out, or of a span of it, was off in its last frame.
struct ForecastError {
  std::string file = {}, motion = {};  ///< of the capture
  std::string part = {};               ///< id of what was predicted: the capture, or its span
  std::string quantity = {};           ///< with the horizon: "position, 0.1 s ahead"
  std::string unit = {};
  std::string predictor = {};  ///< "model", or the name of a baseline
  double distance = 0.0;       ///< in `unit`
  /// Continuous ranked probability score, the mean over components, in `unit`; NaN without PredictionOptions::mixture.
  double crps = std::numeric_limits<double>::quiet_NaN();
};

struct ForecastErrors {
  std::vector<ForecastError> errors = {};
  std::string lack = {};  ///< why none is of the model, in one sentence; empty: some are
};

/// The same forecast by forecast: those that reach the end of what is to be predicted, the model's where it did not
/// fail.
/// @param warnings sentences as cross_validate() adds them
/// @throws as cross_validate()
ForecastErrors cross_validated_errors(const models::TrajectoryFamily& family,
                                      std::span<const Capture> captures, const FitOptions& options,
                                      const PredictionOptions& prediction, const Folds& folds,
                                      Warnings& warnings);

/// What cross_validate() would refuse after a fit of `captures`, refused before it.
/// @throws ArgumentError
void check_folds(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                 const FitOptions& options, const PredictionOptions& prediction, const Folds& folds);

/// What predict_left_out() would refuse after a fit of `captures`, refused before it.
/// @throws ArgumentError, InputError
void check_left_out(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                    std::span<const Capture> left_out, const FitOptions& options,
                    const PredictionOptions& prediction);

}  // namespace samara::identification
