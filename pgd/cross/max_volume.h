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
/// @param groups of the rows, numbers from 0 on, where rows of few groups are to be chosen: a row of a new one comes in
/// only where it is four times as large. Coefficients of rows of groups that are not in are then at most four times
/// 1.05. Empty: each row stands for itself
MaxVolume max_volume(const Eigen::MatrixXd& matrix, int max_rank, double negligible,
                     const std::vector<int>& groups = {});

}  // namespace samara::pgd
