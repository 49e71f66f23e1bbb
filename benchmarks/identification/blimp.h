#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "real_data.h"
#include "samara/identification/captures/capture.h"
#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/identification/problem/fit_result.h"

/// Flights of a miniature blimp with two propellers (Zhu, Cheng, Zhang, IEEE Robot. Autom. Lett. 9 (2024)
/// 10986-10993), by the model `coefficient_body`. The place of the gondola and the thrusts are known, and
/// constant in each flight.
namespace samara::benchmarks::identification {

using samara::identification::Capture;
using samara::identification::FitResult;

struct BlimpFlight {
  int number = 0;
  bool is_spiral = false;
  Capture capture;  ///< labels: "flight", and what is known of it by the names of the model's parameters
};

/// In the order of their numbers.
/// @param sidecar of the tables
std::vector<BlimpFlight> read_blimp(const std::filesystem::path& folder,
                                    const std::filesystem::path& sidecar);

/// Eight flights to fit, four left out, a spiral on each side.
struct BlimpSplit {
  std::vector<BlimpFlight> training, left_out;
};
BlimpSplit split_blimp(const std::vector<BlimpFlight>& flights, const std::vector<int>& left_out);

/// The 21 coefficients that the makers published.
const Coefficients& makers_coefficients();
/// Names of the 21 coefficients, in the order of the model.
const std::vector<std::string>& blimp_coefficients();

enum class AddedMass { none, diagonal };

/// From windows of a second, each from the state measured at its start, clustered by flight. 21 coefficients,
/// with diagonal added mass and inertia 27.
/// @param initial where the descent begins; others at zero, or in the middle of their boxes
FitResult fit_blimp(const std::vector<BlimpFlight>& flights, AddedMass added_mass = AddedMass::none,
                    const Coefficients& initial = {});

/// Standard errors by leaving out one flight at a time (jackknife).
Coefficients jackknife_errors(const std::vector<BlimpFlight>& flights);

/// The body, by the model's names: the makers' measurements, and what is known of a flight.
std::map<std::string, double> blimp_body(const BlimpFlight& flight);

/// A moment of a flight: what baselines saw for a tenth of a second, and where it was later.
struct BlimpMoment {
  std::size_t flight = 0;                        ///< place among the flights
  Eigen::Index origin = 0;                       ///< its last frame that counts as seen
  samara::identification::SeenMotion seen = {};  ///< with velocities in the world
  double time = 0.0;                             ///< s, in the times of what was seen
  Eigen::RowVector3d next = {};                  ///< m
};
/// A tenth of a second apart, the flights in turn. @param ahead s, after the last frame seen
std::vector<BlimpMoment> blimp_moments(const std::vector<BlimpFlight>& flights, double ahead);

/// Errors at a time after the last frame that predictors saw, from many moments of all flights.
struct BlimpErrors {
  std::vector<double> position;  ///< m, distance
  std::vector<double> pitch;     ///< rad
};
/// By predictor: "model", and every baseline; "measured velocity" sees velocities and attitudes, as the model
/// does. All see the same frames before.
/// @param ahead s
std::map<std::string, BlimpErrors> predict_blimp(const std::vector<BlimpFlight>& flights,
                                                 const Coefficients& coefficients, double ahead);

}  // namespace samara::benchmarks::identification
