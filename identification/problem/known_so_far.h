#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/fit_result.h"

/// Internal to identification/: what a fit says of its coefficients, as a normal distribution.
namespace samara::identification {

struct KnownSoFar {
  std::vector<std::string> names = {};
  Eigen::VectorXd values, lower, upper;  ///< SI; of their boxes
  Eigen::VectorXd errors;                ///< standard deviations
  /// Those of clusters times t/1.96, with the quantile t of Student's distribution: two to either side hold 95 %.
  Eigen::VectorXd widened;
  Eigen::MatrixXd correlation;        ///< positive definite
  std::vector<char> determined = {};  ///< else the deviation is that of the box
  bool is_clustered = false;          ///< whether errors are those of the scatter between clusters
  double inflation = 1.0;  ///< variance from clusters over the naive one, the geometric mean; 1 or more

  /// coefficients x count: the values themselves, then quasi-random normal ones, pulled back into the box.
  Eigen::MatrixXd draws(int count, std::uint64_t seed) const;
};

/// The errors of the scatter between clusters are taken where residuals are not white at the 5 % level, or
/// where they exceed the naive ones by more than chance does at that level; else the naive ones, which few
/// clusters tell better. Correlations are those of frames as independent: the scatter of few clusters has
/// directions without any.
/// @throws ArgumentError for a fit without coefficients, for errors that are not positive and finite, and for
/// matrices of another size.
KnownSoFar known_so_far(const FitResult& fitted);

}  // namespace samara::identification
