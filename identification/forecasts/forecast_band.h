#pragma once

#include <Eigen/Core>

#include "samara/identification/forecasts/forecast.h"

/// Mixtures of normal distributions as a mean and a band, number by number.
namespace samara::identification {

/// Where forecasts lie, times x outputs; NaN where a forecast says nothing. A certain one (variance 0) has a band of no
/// width.
struct ForecastBand {
  Eigen::MatrixXd mean = {}, lower = {}, upper = {};
};

/// @param probability that a value lies in the band; as much lies below as above it
/// @throws ArgumentError for a probability that is not between 0 and 1
ForecastBand band_of(const Forecast& forecast, double probability = 0.9);

}  // namespace samara::identification
