#pragma once

#include <Eigen/Core>

/// Internal to identification/: covariances of which some numbers, or some combinations, do not vary.
namespace samara::identification {

/// A root R of a covariance, R R^T, with a column for each combination that varies (Cholesky, the largest pivot first).
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance);

/// The inverse of a covariance in what varies, zero in what does not.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& covariance);

}  // namespace samara::identification
