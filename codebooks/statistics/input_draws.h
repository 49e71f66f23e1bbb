#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/statistics/book_statistics.h"

/// Internal to codebooks/.
namespace samara::codebooks {

/// Of a coordinate that is a list of values.
struct ListValues {
  Eigen::VectorXd values;   ///< of all pieces, ascending
  Eigen::VectorXd weights;  ///< what each counts: nodes of a mesh their areas, other values one
};

/// One per coordinate without time; empty of intervals.
/// @param fixed coordinates that are held, SI: only pieces that hold these values count
/// @throws ArgumentError for a coordinate that is a list in one piece and an interval in another; OutsideBoxError if no
///   piece holds the values
std::vector<std::optional<ListValues>> list_values(const Codebook& book,
                                                   const std::map<std::string, double>& fixed);

struct InputDraws {
  /// Coordinates without time, in order x draws; those that are held stand there, too.
  Eigen::MatrixXd points;
  double share_inside = 1;  ///< of draws of a joint distribution, inside the box
};

/// Scrambled Sobol' points, each coordinate as it is distributed inside the box. Of inputs that are normal together,
/// draws outside the box are left out.
/// @throws ArgumentError if the covariance is none; as list_values()
InputDraws draw_inputs(const Codebook& book, const StatisticsRequest& request);

/// Fills the quantiles, and where inputs are correlated mean and deviation, from such draws.
/// @param statistics with times and outputs by name
void add_from_draws(const Codebook& book, const StatisticsRequest& request, const InputDraws& draws,
                    BookStatistics& statistics);

}  // namespace samara::codebooks
