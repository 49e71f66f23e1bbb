#include "samara/identification/following/covariances.h"

#include <cmath>

#include <Eigen/Cholesky>

namespace samara::identification {

namespace {

/// Of a variance, once all are scaled to 1: what is left of it beyond the others is round-off.
constexpr double kNoVariance = 1e-13;

}  // namespace

Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance) {
  const Eigen::Index size = covariance.rows();
  Eigen::VectorXd scales = covariance.diagonal();
  for (double& scale : scales) scale = scale > 0.0 ? std::sqrt(scale) : 0.0;
  Eigen::MatrixXd left = covariance;  // what the columns so far do not give, scaled
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      const double scale = scales[i] * scales[j];
      left(i, j) = scale > 0.0 ? covariance(i, j) / scale : 0.0;
    }
  }
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(size, size);
  Eigen::Index columns = 0;
  for (; columns < size; ++columns) {
    Eigen::Index pivot = 0;
    const double variance = left.diagonal().maxCoeff(&pivot);
    if (!(variance > kNoVariance)) break;
    root.col(columns) = left.col(pivot) / std::sqrt(variance);
    for (Eigen::Index j = 0; j < size; ++j) left.col(j) -= root(j, columns) * root.col(columns);
  }
  for (Eigen::Index i = 0; i < size; ++i) root.row(i) *= scales[i];
  return root.leftCols(columns);
}

Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& covariance) {
  // With C = R R^T: R (R^T R)^-2 R^T, the inverse in the space of the columns, where they are scaled.
  const Eigen::Index size = covariance.rows();
  Eigen::VectorXd scales = covariance.diagonal();
  for (double& scale : scales) scale = scale > 0.0 ? 1.0 / std::sqrt(scale) : 0.0;
  Eigen::MatrixXd scaled = covariance;
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) scaled(i, j) *= scales[i] * scales[j];
  }
  const Eigen::MatrixXd root = root_of(scaled);
  const Eigen::MatrixXd gram = root.transpose() * root;
  const Eigen::LLT<Eigen::MatrixXd> llt(gram);
  const Eigen::MatrixXd half = llt.solve(root.transpose());
  Eigen::MatrixXd inverse = half.transpose() * half;
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) inverse(i, j) *= scales[i] * scales[j];
  }
  return inverse;
}

}  // namespace samara::identification
