#pragma once

#include <span>
#include <vector>

#include "samara/identification/capture.h"
#include "samara/identification/fit_options.h"
#include "samara/identification/fit_result.h"
#include "samara/identification/prediction_score.h"
#include "samara/identification/trajectory_source.h"

/// How well fitted coefficients predict captures that were left out of the fit.
///
/// Of each such capture the first `window` seconds are seen, attitudes too if the fit compared them: its own
/// unknowns (initial values, offsets) are fitted there with the coefficients held, and the model is carried
/// on. Baselines (prediction_score.h) see the same window. Compared are the frames that follow, up to `ahead`
/// seconds after the window.
///
///     const FitResult result = fit(*family, training, options);
///     const auto scores = predict_left_out(*family, result, test, options, {.window = 0.2, .ahead = 0.1});
namespace samara::identification {

struct PredictionOptions {
  double window = 0.0;  ///< s of each capture that are seen, from its first frame
  double ahead = 0.0;   ///< s beyond it
};

/// Scores of the model and of every baseline, for each quantity: outputs that are lengths together, as the
/// distance in space ("position"); every other output by itself. For each, two scores: over all frames ahead
/// ("position, up to 0.1 s ahead"; less where no capture goes so far), and of the last one, within the last
/// tenth of the way ("position, 0.1 s ahead"). Captures that have too few frames in the window or none beyond
/// are left out of all scores; those on which the fit of the window fails, of the model's. A score that no
/// capture counts for is left out.
/// @param fitted its coefficients are held at their values
/// @param options of that fit; window, starts and roles of what is not held are taken over
/// @returns nothing if the fit failed
/// @throws ArgumentError as fit(), for a capture that does not measure what was fitted, and for times that
/// are not positive; InputError for a capture of a file that was fitted itself.
std::vector<PredictionScore> predict_left_out(const TrajectoryFamily& family, const FitResult& fitted,
                                              std::span<const Capture> left_out, const FitOptions& options,
                                              const PredictionOptions& prediction);

/// The same into the result: scores into `predictions`, and sentences into `warnings` about captures that
/// could not be predicted, or not by the model, or not so far ahead.
void add_predictions(const TrajectoryFamily& family, std::span<const Capture> left_out,
                     const FitOptions& options, const PredictionOptions& prediction, FitResult& fitted);

/// What predict_left_out() would refuse after a fit of `captures`, refused before it.
/// @throws ArgumentError, InputError
void check_left_out(const TrajectoryFamily& family, std::span<const Capture> captures,
                    std::span<const Capture> left_out, const FitOptions& options,
                    const PredictionOptions& prediction);

}  // namespace samara::identification
