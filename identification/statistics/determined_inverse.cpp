#include "samara/identification/statistics/determined_inverse.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace samara::identification {

DeterminedInverse invert_determined(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& floor) {
  const Eigen::Index n = matrix.rows();
  DeterminedInverse result;
  result.inverse.setZero(n, n);
  result.determined.assign(static_cast<std::size_t>(n), 1);
  if (n == 0) return result;

  // Unit diagonal: then an eigenvalue says how far its combination is from being redundant.
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (matrix(i, i) > floor[i] && matrix(i, i) > 0.0) {
      scale[i] = 1.0 / std::sqrt(matrix(i, i));
    } else {
      result.determined[static_cast<std::size_t>(i)] = 0;
      result.undetermined_sets.push_back({static_cast<int>(i)});
    }
  }
  Eigen::MatrixXd scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (scale[i] == 0.0) scaled(i, i) = 1.0;  // decoupled; its row of the inverse is zeroed by the scale
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  // J^T J of derivatives known to 1e-9 or so: smaller eigenvalues than the square of a safe multiple are
  // none.
  constexpr double kRedundant = 1e-12;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::VectorXd vector = eigen.eigenvectors().col(k);
    if (eigen.eigenvalues()[k] > kRedundant) {
      const Eigen::VectorXd column = scale.cwiseProduct(vector);
      result.inverse += column * column.transpose() / eigen.eigenvalues()[k];
      continue;
    }
    std::vector<int> members;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (std::abs(vector[i]) < 0.05) continue;
      members.push_back(static_cast<int>(i));
      result.determined[static_cast<std::size_t>(i)] = 0;
    }
    result.undetermined_sets.push_back(std::move(members));
  }
  return result;
}

}  // namespace samara::identification
