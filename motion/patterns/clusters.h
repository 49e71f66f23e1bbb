#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

/// Clusters of points, to find kinds within a pattern. They are no patterns: which clusters come out hangs on which
/// features go in and how they are scaled (docs/explanation/pattern_names.md).
namespace samara::motion {

struct ClusterOptions {
  int clusters = 4;
  int restarts = 10;  ///< of which the best is kept
  int max_iterations = 300;
  double tolerance = 1e-9;  ///< stop when the objective changes by less than this of itself
  std::uint64_t seed = 1;
};

struct Clusters {
  std::vector<int> assignment;  ///< per point; numbered from the largest cluster on
  Eigen::MatrixXd centres;      ///< clusters x columns; of a cluster without points, the last place it had
  double objective = 0.0;       ///< k-means: sum of squared distances; mixture: mean log-likelihood
  std::vector<double> history;  ///< objective after each iteration of the best start
  bool converged = false;
  std::string message = "not run";  ///< how it ended, and how many clusters have no points, if any
};

/// Columns shifted to mean 0 and scaled to deviation 1; a column that does not vary becomes 0.
Eigen::MatrixXd standardised(const Eigen::MatrixXd& points);

/// Lloyd's iterations from k-means++ seeds (D. Arthur, S. Vassilvitskii, SODA 2007).
/// @throws ArgumentError for points that are not finite, above kLargestInput (base/limits.h) or fewer than clusters, or
///   options outside their meaning.
Clusters k_means(const Eigen::MatrixXd& points, const ClusterOptions& options = {});

/// Gaussian mixture with full covariances by expectation and maximisation, begun at k-means; each covariance has
/// 1e-6 of the mean variance added, so that a cluster cannot shrink to a point.
/// @throws ArgumentError likewise.
Clusters gaussian_mixture(const Eigen::MatrixXd& points, const ClusterOptions& options = {});

}  // namespace samara::motion
