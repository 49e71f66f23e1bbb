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
/// ("position, up to 0.1 s ahead"), and of the last one, within the last tenth of the way ("position, 0.1 s
/// ahead"). Captures that have too few frames in the window or none beyond, or on which the fit of the window
/// fails, are left out of all scores alike.
/// @param fitted its coefficients are held at their values
/// @param options of that fit; window, starts and roles of what is not held are taken over
/// @returns nothing if the fit failed
/// @throws ArgumentError as fit(), for a capture that does not measure what was fitted, and for times that
/// are not positive.
std::vector<PredictionScore> predict_left_out(const TrajectoryFamily& family, const FitResult& fitted,
                                              std::span<const Capture> left_out, const FitOptions& options,
                                              const PredictionOptions& prediction);

}  // namespace samara::identification
