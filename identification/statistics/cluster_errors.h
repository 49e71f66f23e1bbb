#pragma once

#include <vector>

#include <Eigen/Core>

/// Internal to identification/: errors of shared unknowns from the scatter between clusters of captures.
namespace samara::identification {

/// What one cluster says of the unknowns at the answer: curvature and gradient of its part of the cost.
struct ClusterTerms {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd score;
};

struct ClusterErrors {
  Eigen::MatrixXd covariance;
  /// Unknowns x clusters: of the information on an unknown, the part that comes from a cluster. Rows sum to
  /// 1, less what priors give.
  Eigen::MatrixXd shares;
};

/// With H = sum_c H_c + P = L L^T, a cluster's leverage M_c = L^-1 H_c L^-T and u_c = L^-1 g_c,
///
///     cov = L^-T (sum_c v_c v_c^T + L^-1 P L^-T) L^-1,   v_c = (1 - M_c)^-1/2 u_c.
///
/// The answer lies where the scores of clusters sum to nothing, so that a cluster which decides an unknown by
/// itself shows no scatter there: its score is divided by what the answer has taken from it. This is the
/// correction CR2 of R. M. Bell and D. F. McCaffrey, Survey Methodology 28 (2002) 169-181, right in the mean
/// where scores vary as much as their clusters inform; with clusters that are all alike it is C/(C - 1)
/// without it.
///
/// Where one or two clusters carry an unknown (effective_clusters below kFewClusters), even that rests on one
/// or two numbers: its error is then at least the one that the scatter of all clusters in all unknowns gives,
/// phi H^-1 with phi = sum_c |v_c|^2/sum_c tr M_c.
///
/// @param clusters two or more
/// @param priors P, the information of priors
/// @returns a covariance that is NaN if H is not positive
ClusterErrors cluster_errors(const std::vector<ClusterTerms>& clusters, const Eigen::MatrixXd& priors);

inline constexpr double kFewClusters = 2.5;

/// The number of clusters that would give as rough an error if they said equally much: one over the sum of
/// the squares of the shares of the data (C. A. Carter, K. T. Schnepel, D. G. Steigerwald, Rev. Econ. Stat.
/// 99 (2017) 698-709). 0 if data say nothing.
double effective_clusters(const Eigen::VectorXd& shares);

/// Degrees of freedom on which an error from cluster_errors() rests: those of the clusters that carry the
/// unknown, or of all where all clusters have been asked; at least one.
double error_degrees(double effective_clusters, int clusters);

}  // namespace samara::identification
