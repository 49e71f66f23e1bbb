#include "samara/pgd/max_volume.h"

#include <cmath>

#include <Eigen/LU>

namespace samara::pgd {

MaxVolume max_volume(const Eigen::MatrixXd& matrix) {
  constexpr double kBound = 1.05;
  constexpr int kMaxSwaps = 200;
  const Eigen::Index r = matrix.cols();
  // Rows of the pivots of a fully pivoted elimination are a good start.
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(matrix);
  const auto& order = lu.permutationP().indices();
  MaxVolume result;
  result.rows.resize(static_cast<std::size_t>(r));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    if (order[i] < r) result.rows[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
  }
  const Eigen::MatrixXd start = matrix(result.rows, Eigen::all);
  result.coefficients = start.transpose().fullPivLu().solve(matrix.transpose()).transpose();
  for (int swap = 0; swap < kMaxSwaps; ++swap) {
    Eigen::Index row = 0;
    Eigen::Index col = 0;
    if (!(result.coefficients.cwiseAbs().maxCoeff(&row, &col) > kBound)) break;
    result.rows[static_cast<std::size_t>(col)] = static_cast<int>(row);
    // Exchanging one row of the submatrix is a rank-one change of the coefficients.
    Eigen::RowVectorXd change = result.coefficients.row(row);
    change[col] -= 1.0;
    const Eigen::VectorXd column = result.coefficients.col(col) / result.coefficients(row, col);
    result.coefficients.noalias() -= column * change;
  }
  return result;
}

}  // namespace samara::pgd
