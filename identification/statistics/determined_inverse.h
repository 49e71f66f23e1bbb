#pragma once

#include <vector>

#include <Eigen/Core>

/// Internal to identification/.
namespace samara::identification {

/// The inverse of a matrix J^T J on the unknowns that it determines.
struct DeterminedInverse {
  Eigen::MatrixXd inverse;  ///< pseudo-inverse, zero for unknowns without influence
  std::vector<char> determined;
  /// Sets of unknowns that can change together without effect; single ones have no influence at all.
  std::vector<std::vector<int>> undetermined_sets;

  bool all_determined() const { return undetermined_sets.empty(); }
};

/// @param matrix symmetric, positive semidefinite up to rounding
/// @param floor diagonal entries up to this are taken as none
DeterminedInverse invert_determined(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& floor);

}  // namespace samara::identification
