#pragma once

#include <vector>

#include <Eigen/Core>

namespace samara::pgd {

/// Rows of a tall matrix of full column rank whose square submatrix has nearly the largest volume: no entry
/// of `matrix * inverse(submatrix)` exceeds 1.05 in size. Reference: Goreinov, Oseledets, Savostyanov,
/// Tyrtyshnikov, Zamarashkin, How to find a good submatrix (2010).
struct MaxVolume {
  std::vector<int> rows;
  Eigen::MatrixXd coefficients;  ///< matrix * inverse(submatrix)
};

MaxVolume max_volume(const Eigen::MatrixXd& matrix);

}  // namespace samara::pgd
