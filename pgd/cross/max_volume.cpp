#include "samara/pgd/cross/max_volume.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace samara::pgd {

namespace {

using Eigen::Index;

/// Elimination with pivots chosen among all entries, until none exceeds `negligible` or `max_rank` are
/// chosen. `matrix`: L below the diagonal. @returns the rows in the order of the pivots, the others after
std::vector<int> eliminate(Eigen::MatrixXd& matrix, Index max_rank, double negligible, Index& rank) {
  std::vector<int> order(static_cast<std::size_t>(matrix.rows()));
  std::iota(order.begin(), order.end(), 0);
  Eigen::VectorXd largest = matrix.cwiseAbs().colwise().maxCoeff();
  const Index most = std::min({max_rank, matrix.rows(), matrix.cols()});
  for (rank = 0; rank < most; ++rank) {
    const Index below = matrix.rows() - rank - 1;
    Index column = 0, row = 0;
    const double pivot = largest.tail(largest.size() - rank).maxCoeff(&column);
    if (!(pivot > negligible) && rank > 0) break;
    matrix.col(rank).swap(matrix.col(rank + column));
    std::swap(largest[rank], largest[rank + column]);
    matrix.col(rank).tail(below + 1).cwiseAbs().maxCoeff(&row);
    if (row > 0) matrix.row(rank).swap(matrix.row(rank + row));
    std::swap(order[static_cast<std::size_t>(rank)], order[static_cast<std::size_t>(rank + row)]);
    auto multipliers = matrix.col(rank).tail(below);
    if (pivot > 0.0) multipliers /= matrix(rank, rank);
    for (Index j = rank + 1; j < matrix.cols(); ++j) {
      matrix.col(j).tail(below) -= matrix(rank, j) * multipliers;
      largest[j] = below > 0 ? matrix.col(j).tail(below).cwiseAbs().maxCoeff() : 0.0;
    }
  }
  return order;
}

/// The pivots' rows, and all rows by them: L L1^-1 = [I; L2 L1^-1], whatever the columns' condition.
MaxVolume by_elimination(Eigen::MatrixXd matrix, Index max_rank, double negligible) {
  Index rank = 0;
  const std::vector<int> order = eliminate(matrix, max_rank, negligible, rank);
  auto factors = matrix.leftCols(rank);
  const Index below = matrix.rows() - rank;
  factors.topRows(rank).triangularView<Eigen::UnitLower>().solveInPlace<Eigen::OnTheRight>(
      factors.bottomRows(below));
  MaxVolume result;
  result.rows.assign(order.begin(), order.begin() + rank);
  result.coefficients = Eigen::MatrixXd::Zero(matrix.rows(), rank);
  for (Index k = 0; k < rank; ++k) result.coefficients(order[static_cast<std::size_t>(k)], k) = 1.0;
  for (Index i = rank; i < matrix.rows(); ++i)
    result.coefficients.row(order[static_cast<std::size_t>(i)]) = factors.row(i);
  return result;
}

}  // namespace

MaxVolume max_volume(const Eigen::MatrixXd& matrix, int max_rank, double negligible) {
  constexpr double kBound = 1.05;
  constexpr int kMaxSwaps = 200;
  MaxVolume result = by_elimination(matrix, max_rank, negligible);
  for (int swap = 0; swap < kMaxSwaps; ++swap) {
    Index row = 0, col = 0;
    const double largest = result.coefficients.cwiseAbs().colwise().maxCoeff().maxCoeff(&col);
    if (!(largest > kBound)) break;
    result.coefficients.col(col).cwiseAbs().maxCoeff(&row);
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
