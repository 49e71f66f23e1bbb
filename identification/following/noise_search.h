#pragma once

#include <memory>
#include <optional>
#include <span>

#include "samara/base/progress.h"
#include "samara/identification/captures/capture.h"
#include "samara/identification/following/follow_options.h"
#include "samara/models/interface/model.h"

/// What a fit does not say of a motion, chosen on captures of which the rest is known: how much comes over the motion
/// besides the model, how much its coefficients drift and differ from capture to capture, and how noisy frames are.
namespace samara::identification {

/// What is put into FollowOptions.
struct NoiseChoice {
  double noise_factor = 1.0;  ///< of the noise of all frames
  double velocity = 0.3;      ///< ModelNoise::velocity
  double rate = 3.0;          ///< ModelNoise::rate
  double spread = 0.1;  ///< of each capture's coefficients about those of the fit: added to their deviations
  double drift = 0.05;  ///< of every coefficient of the fit
  double score = 0.0;   ///< mean logarithm of the density of what was forecast
  int frames = 0;       ///< that were forecast
  int evaluations = 0;  ///< times that all captures were followed
};

/// Those of the numbers that somebody says; empty: not said.
struct GivenNoise {
  std::optional<double> noise_factor = {}, velocity = {}, rate = {}, spread = {}, drift = {};
};

/// What is given; else frames are as noisy as they are said to be, and nothing is added to the model and its errors.
NoiseChoice as_given(const GivenNoise& given);

struct NoiseSearch {
  /// s: frames are forecast from so long before; 0: from the frame before.
  double ahead = 0.0;
  double stride = 0.0;  ///< s, from origin to origin of forecasts ahead; 0: every frame
  /// Where the search begins, and what it leaves as it is.
  NoiseChoice start = {};
  bool finds_noise_factor = true, finds_velocity = true, finds_rate = true, finds_spread = true,
       finds_drift = true;
  int rounds = 3;  ///< of steps by factors of 4, 2 and 1.4 of each in turn; fewer where nothing gains
  ProgressCallback progress = {};
};

/// The search of what is not given, with the rest held.
NoiseSearch without_given(NoiseSearch search, const GivenNoise& given);

/// Whether any state of the model has such a noise by its unit: ModelNoise::velocity or ModelNoise::rate.
bool has_noise(const models::ModelInfo& info, double ModelNoise::*noise);

/// The options with the choice put in. Spread and drift of a coefficient that is not logarithmic are shares of the size
/// of its value; what is a motion's own has neither.
FollowOptions with_noise(FollowOptions options, const NoiseChoice& choice);

/// How likely forecasts are with a choice.
NoiseChoice score_of(const std::shared_ptr<const models::Model>& model,
                     std::span<const FollowOptions> options, std::span<const Capture> captures,
                     const NoiseSearch& search, NoiseChoice choice);

/// The choice under which frames of these captures were most likely before they were seen, by a search along one
/// number after the other. Noise of velocities, or of rates, is 0 where no state of the model has such a unit. The same
/// captures give the same choice, on any number of threads.
/// @param options of each capture, as follow_options() makes them
/// @throws ArgumentError as Follower, as add_frame(), for as many options as there are not
/// captures, and times that are negative
NoiseChoice choose_noise(const std::shared_ptr<const models::Model>& model,
                         std::span<const FollowOptions> options, std::span<const Capture> captures,
                         const NoiseSearch& search = {});

}  // namespace samara::identification
