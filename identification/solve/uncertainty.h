#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to identification/; the formulas stand in fit.h.
namespace samara::identification {

/// Of the unknowns of one segment.
struct OwnUncertainty {
  Eigen::VectorXd standard_error;  ///< naive; NaN at a bound and where not determined
  std::vector<char> at_bound;
  std::vector<char> determined;
};

/// Of the shared unknowns. Matrices are shared x shared, NaN in rows and columns at a bound or not
/// determined.
struct Uncertainty {
  Eigen::MatrixXd clustered;  ///< all NaN for fewer than two clusters
  Eigen::MatrixXd naive;
  Eigen::MatrixXd cluster_shares;  ///< as ClusterErrors::shares; zero at a bound
  /// Of an unknown at a bound, from two or more clusters: the variance that it would have if it were free, and its
  /// effective clusters. NaN elsewhere, and where it was not asked for.
  Eigen::VectorXd released_variance, released_clusters;
  std::vector<char> at_bound;
  std::vector<char> determined;
  std::vector<std::vector<int>> undetermined_sets;  ///< as in DeterminedInverse
  /// Sets that only priors determine, in the same form; the captures alone would not.
  std::vector<std::vector<int>> sets_held_by_priors;
  /// So many residuals lie beyond the bend of the loss that its Hessian is no use, and mean(psi') J^T J stood in, or
  /// that mean(psi') itself, by which errors are divided, is known to no better than a quarter.
  bool beyond_bend = false;
  std::vector<OwnUncertainty> own;  ///< per segment
  /// Second derivative of the cost by the shared unknowns, the own ones eliminated: psi' J J^T, or mean(psi')
  /// J^T J where that is not positive.
  Eigen::MatrixXd information;
  /// What the cost is to be divided by to be a log-likelihood, frames taken as independent: sum(psi^2)/(n -
  /// p)/mean(psi'). NaN if nothing is left over.
  double dispersion = 0.0;
  int residual_freedom = 0;  ///< n - p: compared numbers less the unknowns that they determine
};

/// @param residuals one per segment; scratch, left at `point`
/// @param point a minimum, at which there are trajectories
/// @param with_released whether what unknowns at bounds would have if they were free is wanted: as much work for each
///   as all other errors together
Uncertainty estimate_uncertainty(const FitProblem& problem, std::vector<SegmentResidual>& residuals,
                                 const FitPoint& point, bool with_released = false);

}  // namespace samara::identification
