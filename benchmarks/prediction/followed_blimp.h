#pragma once

#include <vector>

#include <Eigen/Core>

#include "identification/blimp.h"
#include "samara/identification/following/noise_search.h"

/// Flights of the blimp followed from their first frame on: a forecast rests on all of the past.
namespace samara::benchmarks::prediction {

using identification::BlimpFlight;
using identification::BlimpMoment;
using identification::Coefficients;

/// Flights, each with coefficients of a fit that has not seen it.
struct BlimpAhead {
  std::vector<BlimpFlight> flights = {};
  std::vector<Coefficients> coefficients = {};  ///< of each flight

  void add(const std::vector<BlimpFlight>& more, const Coefficients& of_all);
};

/// How far the model is off, as makes places so far ahead most likely.
/// @param ahead s
samara::identification::NoiseChoice choose_blimp_noise(const BlimpAhead& flights, double ahead);

/// Where the body is forecast to be in each of the moments of blimp_moments(), m: the mean, a row each; NaN where
/// nothing is said.
Eigen::MatrixX3d follow_blimp(const BlimpAhead& flights, const std::vector<BlimpMoment>& moments,
                              double ahead, const samara::identification::NoiseChoice& choice);

}  // namespace samara::benchmarks::prediction
