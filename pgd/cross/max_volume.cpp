#include "samara/pgd/cross/max_volume.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/LU>

#include "samara/base/parallel.h"

namespace samara::pgd {

namespace {

using Eigen::Index;

/// Of what coefficients count.
constexpr double kBound = 1.05;
/// Columns that a thread takes at a time.
constexpr Index kColumns = 64;

/// body(first, count) for blocks of the columns from `first` on, the same ones whatever the number of threads.
template <class Body>
void for_column_blocks(Index first, Index last, const Body& body) {
  parallel_for((last - first + kColumns - 1) / kColumns, [&](Index block) {
    const Index begin = first + block * kColumns;
    body(begin, std::min(kColumns, last - begin));
  });
}

/// Rows of new groups count so much of their size beside those of groups that are in the submatrix.
constexpr double kShareOfNewGroups = 0.25;

/// Which rows count less.
class Groups {
 public:
  /// @param of_rows empty: every row counts the same
  explicit Groups(const std::vector<int>& of_rows) : of_rows_(of_rows) {
    if (!of_rows.empty()) taken_.resize(static_cast<std::size_t>(1 + *std::ranges::max_element(of_rows)));
  }

  double share(Index row) const {
    return of_rows_.empty() || taken_[group_of(row)] != 0 ? 1.0 : kShareOfNewGroups;
  }
  void take(Index row) {
    if (!of_rows_.empty()) taken_[group_of(row)] = 1;
  }

 private:
  std::size_t group_of(Index row) const {
    return static_cast<std::size_t>(of_rows_[static_cast<std::size_t>(row)]);
  }

  const std::vector<int>& of_rows_;
  std::vector<char> taken_;
};

/// Elimination with pivots chosen among all entries, until none exceeds `negligible` or `max_rank` are chosen. Columns
/// of the largest entries, the candidates, are eliminated one by one among themselves, and a panel of them from all
/// others by one product of matrices.
class Elimination {
 public:
  Elimination(Eigen::MatrixXd& matrix, Index max_rank, double negligible, Groups& groups)
      : matrix_(matrix),
        groups_(groups),
        negligible_(negligible),
        most_(std::min({max_rank, matrix.rows(), matrix.cols()})),
        order_(static_cast<std::size_t>(matrix.rows())),
        largest_(matrix.cwiseAbs().colwise().maxCoeff()) {
    std::iota(order_.begin(), order_.end(), 0);
  }

  /// `matrix`: L below the diagonal. @returns the rows in the order of the pivots, the others after
  std::vector<int> run() {
    constexpr Index kPanel = 16, kCandidates = 48;
    while (rank_ < most_) {
      const Index first = rank_, behind = std::min(first + kCandidates, matrix_.cols());
      bring_forward(behind);
      while (rank_ < std::min({first + kPanel, most_, behind}) && take_pivot(behind)) {
      }
      if (rank_ == first) break;
      eliminate_from_others(first, behind);
    }
    return std::move(order_);
  }

  Index rank() const { return rank_; }

 private:
  /// Columns of the largest entries come first among those that are left, up to column `behind`.
  void bring_forward(Index behind) {
    std::vector<Index> columns(static_cast<std::size_t>(matrix_.cols() - rank_));
    std::iota(columns.begin(), columns.end(), rank_);
    const auto last = columns.begin() + (behind - rank_);
    std::partial_sort(columns.begin(), last, columns.end(), [&](Index a, Index b) {
      return largest_[a] > largest_[b] || (largest_[a] == largest_[b] && a < b);
    });
    std::sort(columns.begin(), last);
    Index place = rank_;
    for (auto column = columns.begin(); column != last; ++column, ++place) swap_columns(place, *column);
  }

  void swap_columns(Index a, Index b) {
    if (a == b) return;
    matrix_.col(a).swap(matrix_.col(b));
    std::swap(largest_[a], largest_[b]);
  }

  /// One step among the candidates. @returns false if what is left of them is negligible
  bool take_pivot(Index behind) {
    Index column = 0;
    const double pivot = largest_.segment(rank_, behind - rank_).maxCoeff(&column);
    if (!(pivot > negligible_) && rank_ > 0) return false;
    swap_columns(rank_, rank_ + column);
    const Index row = heaviest_row();
    if (row > rank_) matrix_.row(rank_).swap(matrix_.row(row));
    std::swap(order_[static_cast<std::size_t>(rank_)], order_[static_cast<std::size_t>(row)]);
    groups_.take(order_[static_cast<std::size_t>(rank_)]);
    const Index below = matrix_.rows() - rank_ - 1;
    auto multipliers = matrix_.col(rank_).tail(below);
    if (pivot > 0.0) multipliers /= matrix_(rank_, rank_);
    for (Index j = rank_ + 1; j < behind; ++j) {
      matrix_.col(j).tail(below) -= matrix_(rank_, j) * multipliers;
      largest_[j] = largest_below(j, below);
    }
    ++rank_;
    return true;
  }

  /// Where the next column is largest, rows of new groups counted less.
  Index heaviest_row() const {
    Index heaviest = rank_;
    double weight = -1.0;
    for (Index i = rank_; i < matrix_.rows(); ++i) {
      const double own = groups_.share(order_[static_cast<std::size_t>(i)]) * std::abs(matrix_(i, rank_));
      if (own > weight) {
        weight = own;
        heaviest = i;
      }
    }
    return heaviest;
  }

  double largest_below(Index column, Index below) const {
    return below > 0 ? matrix_.col(column).tail(below).cwiseAbs().maxCoeff() : 0.0;
  }

  /// The pivots from `first` on, from the columns that were no candidates.
  void eliminate_from_others(Index first, Index behind) {
    const Index count = rank_ - first, below = matrix_.rows() - rank_;
    const auto panel = matrix_.block(first, first, count, count);
    const auto multipliers = matrix_.block(rank_, first, below, count);
    for_column_blocks(behind, matrix_.cols(), [&](Index begin, Index columns) {
      auto top = matrix_.block(first, begin, count, columns);
      panel.template triangularView<Eigen::UnitLower>().solveInPlace(top);
      matrix_.block(rank_, begin, below, columns).noalias() -= multipliers * top;
      for (Index j = begin; j < begin + columns; ++j) largest_[j] = largest_below(j, below);
    });
  }

  Eigen::MatrixXd& matrix_;
  Groups& groups_;
  const double negligible_;
  const Index most_;
  std::vector<int> order_;
  Eigen::VectorXd largest_;  ///< per column, of what is left of it
  Index rank_ = 0;
};

/// The pivots' rows, and all rows by them: L L1^-1 = [I; L2 L1^-1], whatever the columns' condition.
MaxVolume by_elimination(Eigen::MatrixXd matrix, Index max_rank, double negligible, Groups groups) {
  Elimination elimination(matrix, max_rank, negligible, groups);
  const std::vector<int> order = elimination.run();
  const Index rank = elimination.rank();
  auto factors = matrix.leftCols(rank);
  const Index below = matrix.rows() - rank;
  factors.topRows(rank).triangularView<Eigen::UnitLower>().solveInPlace<Eigen::OnTheRight>(
      factors.bottomRows(below));
  MaxVolume result;
  result.rows.assign(order.begin(), order.begin() + rank);
  result.coefficients = Eigen::MatrixXd::Zero(matrix.rows(), rank);
  for (Index k = 0; k < rank; ++k) {
    result.coefficients(order[static_cast<std::size_t>(k)], k) = 1.0;
    for (Index i = rank; i < matrix.rows(); ++i)
      result.coefficients(order[static_cast<std::size_t>(i)], k) = factors(i, k);
  }
  return result;
}

/// Rows that came into the submatrix, each in the place of one of its rows.
struct Swaps {
  std::vector<Index> rows, places;
};

/// Swaps that enlarge the volume most, one after the other, among some rows.
/// @param shares what entries of these rows count
Swaps swaps_among(const std::vector<Index>& rows, const Eigen::VectorXd& shares,
                  const Eigen::MatrixXd& coefficients, int most) {
  Swaps swaps;
  Eigen::MatrixXd some = coefficients(rows, Eigen::all);
  for (int count = 0; count < most; ++count) {
    Index row = 0, place = 0;
    if (!((shares.asDiagonal() * some).cwiseAbs().maxCoeff(&row, &place) > kBound)) break;
    // Exchanging one row of the submatrix is a rank-one change of the coefficients.
    Eigen::RowVectorXd change = some.row(row);
    change[place] -= 1.0;
    const Eigen::VectorXd column = some.col(place) / some(row, place);
    some.noalias() -= column * change;
    const auto known = std::ranges::find(swaps.places, place);
    if (known == swaps.places.end()) {
      swaps.rows.push_back(rows[static_cast<std::size_t>(row)]);
      swaps.places.push_back(place);
    } else {
      swaps.rows[static_cast<std::size_t>(known - swaps.places.begin())] =
          rows[static_cast<std::size_t>(row)];
    }
  }
  return swaps;
}

/// All of the swaps at once: a change of the coefficients of as many ranks.
void apply(const Swaps& swaps, MaxVolume& volume) {
  Eigen::MatrixXd& coefficients = volume.coefficients;
  const Eigen::MatrixXd columns = coefficients(Eigen::all, swaps.places);
  Eigen::MatrixXd change = coefficients(swaps.rows, Eigen::all);
  for (std::size_t k = 0; k < swaps.rows.size(); ++k) {
    change(static_cast<Index>(k), swaps.places[k]) -= 1.0;
    volume.rows[static_cast<std::size_t>(swaps.places[k])] = static_cast<int>(swaps.rows[k]);
  }
  change = Eigen::MatrixXd(columns(swaps.rows, Eigen::all)).partialPivLu().solve(change);
  for_column_blocks(0, coefficients.cols(), [&](Index begin, Index count) {
    coefficients.middleCols(begin, count).noalias() -= columns * change.middleCols(begin, count);
  });
}

}  // namespace

MaxVolume max_volume(const Eigen::MatrixXd& matrix, int max_rank, double negligible,
                     const std::vector<int>& groups) {
  constexpr int kMaxPasses = 40, kSwapsPerPass = 16;
  MaxVolume result = by_elimination(matrix, max_rank, negligible, Groups(groups));
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    Groups taken(groups);
    for (const int row : result.rows) taken.take(row);
    Eigen::VectorXd shares(matrix.rows());
    for (Index i = 0; i < shares.size(); ++i) shares[i] = taken.share(i);
    std::vector<Index> rows;
    for (const auto& column : result.coefficients.colwise()) {
      Index row = 0;
      if (column.cwiseAbs().cwiseProduct(shares).maxCoeff(&row) > kBound) rows.push_back(row);
    }
    if (rows.empty()) break;
    std::ranges::sort(rows);
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    apply(swaps_among(rows, shares(rows), result.coefficients, kSwapsPerPass), result);
  }
  return result;
}

}  // namespace samara::pgd
