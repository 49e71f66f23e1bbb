#include "followed_blimp.h"

#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "samara/base/parallel.h"
#include "samara/identification/following/followed_motion.h"
#include "samara/identification/following/follower.h"
#include "samara/identification/forecasts/forecast_band.h"
#include "samara/models/laws/registry.h"

namespace samara::benchmarks::prediction {

namespace {

using samara::identification::Follower;
using samara::identification::FollowOptions;
using samara::identification::NoiseChoice;

// Of motion capture: what the model lacks is much more.
constexpr double kPlaceNoise = 1e-4;     // m
constexpr double kAttitudeNoise = 5e-4;  // rad
constexpr int kStartFrames = 7;          // of the first moment
constexpr double kStep = 0.0168;         // s: one of RK4 a frame

std::shared_ptr<const models::Model> blimp_model() {
  return models::find_model("coefficient_body");
}

/// Coefficients are held: those of a flight's own made forecasts of training flights no likelier.
FollowOptions options_of(const BlimpFlight& flight, const Coefficients& coefficients) {
  FollowOptions options;
  options.noise = {{"x", kPlaceNoise}, {"y", kPlaceNoise}, {"z", kPlaceNoise}};
  options.attitude_noise = kAttitudeNoise;
  options.fixed = identification::blimp_body(flight);
  options.step = kStep;
  options.start_frames = kStartFrames;
  options.forecasts = samara::identification::ForecastOrder::first;
  for (const char* velocity : {"ux", "uy", "uz"}) options.start[velocity] = {0.3, 0.5};
  for (const char* rate : {"wx", "wy", "wz"}) options.start[rate] = {0.0, 0.5};
  options.fixed.insert(coefficients.begin(), coefficients.end());
  return options;
}

std::vector<FollowOptions> options_of(const BlimpAhead& flights) {
  std::vector<FollowOptions> options;
  for (std::size_t k = 0; k < flights.flights.size(); ++k)
    options.push_back(options_of(flights.flights[k], flights.coefficients[k]));
  return options;
}

}  // namespace

void BlimpAhead::add(const std::vector<BlimpFlight>& more, const Coefficients& of_all) {
  flights.insert(flights.end(), more.begin(), more.end());
  coefficients.insert(coefficients.end(), more.size(), of_all);
}

NoiseChoice choose_blimp_noise(const BlimpAhead& flights, double ahead) {
  std::vector<samara::identification::Capture> captures;
  for (const BlimpFlight& flight : flights.flights) captures.push_back(flight.capture);
  constexpr double kStride = 0.5;  // s, as of moments
  return choose_noise(blimp_model(), options_of(flights), captures,
                      {.ahead = ahead,
                       .stride = kStride,
                       .start = {.velocity = 0.02, .rate = 0.1},
                       .finds_noise_factor = false,
                       .finds_spread = false,
                       .finds_drift = false});
}

Eigen::MatrixX3d follow_blimp(const BlimpAhead& flights, const std::vector<BlimpMoment>& moments,
                              double ahead, const NoiseChoice& choice) {
  Eigen::MatrixX3d next =
      Eigen::MatrixX3d::Constant(std::ssize(moments), 3, std::numeric_limits<double>::quiet_NaN());
  const std::vector<FollowOptions> options = options_of(flights);
  parallel_for(flights.flights.size(), [&](std::size_t flight) {
    Follower follower(blimp_model(), with_noise(options[flight], choice));
    const samara::identification::Capture& capture = flights.flights[flight].capture;
    const Eigen::MatrixXd values =
        samara::identification::frames_of(follower, blimp_model()->info(), capture);
    Eigen::RowVectorXd frame(values.cols());
    Eigen::Index added = 0;
    for (std::size_t k = 0; k < moments.size(); ++k) {
      if (moments[k].flight != flight) continue;
      for (; added <= moments[k].origin; ++added) {
        frame = values.row(added);
        follower.add(capture.times[added], {frame.data(), static_cast<std::size_t>(frame.size())});
      }
      if (!follower.is_following()) continue;
      const auto band = samara::identification::band_of(
          follower.forecast(std::array{capture.times[moments[k].origin] + ahead}, {"x", "y", "z"}));
      next.row(static_cast<Eigen::Index>(k)) = band.mean.row(0);
    }
  });
  return next;
}

}  // namespace samara::benchmarks::prediction
