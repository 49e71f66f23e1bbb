#pragma once

#include <vector>

#include <Eigen/Core>

namespace samara::pgd {

/// Columns of a matrix, and as many of its rows, whose square submatrix has nearly the largest volume: all
/// rows of these columns are combinations of those rows with coefficients of at most 1.05 in size.
/// Reference: Goreinov, Oseledets, Savostyanov, Tyrtyshnikov, Zamarashkin, How to find a good submatrix
/// (2010).
struct MaxVolume {
  std::vector<int> rows;
  Eigen::MatrixXd coefficients;  ///< columns * inverse(submatrix)
};

/// @param negligible columns are chosen until no entry of the others exceeds this once the chosen ones are
/// eliminated from them
MaxVolume max_volume(const Eigen::MatrixXd& matrix, int max_rank, double negligible);

}  // namespace samara::pgd
