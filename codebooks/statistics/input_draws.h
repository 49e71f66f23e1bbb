#pragma once

#include <Eigen/Core>

#include "samara/codebooks/statistics/book_statistics.h"

/// Internal to codebooks/.
namespace samara::codebooks {

struct InputDraws {
  /// Coordinates without time, in order x draws; those that are held stand there, too.
  Eigen::MatrixXd points;
  double share_inside = 1;  ///< of draws of a joint distribution, inside the box
};

/// Scrambled Sobol' points, each coordinate as it is distributed inside the box. Of inputs that are normal together,
/// draws outside the box are left out.
/// @throws ArgumentError if the covariance is none
InputDraws draw_inputs(const Codebook& book, const StatisticsRequest& request);

/// Fills the quantiles, and where inputs are correlated mean and deviation, from such draws.
/// @param statistics with times and outputs by name
void add_from_draws(const Codebook& book, const StatisticsRequest& request, const InputDraws& draws,
                    BookStatistics& statistics);

}  // namespace samara::codebooks
