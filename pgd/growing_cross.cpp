#include "samara/pgd/growing_cross.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/QR>

namespace samara::pgd {

namespace {

constexpr int kRookSteps = 2;

bool has_column(const IndexBatch& set, const Eigen::VectorXi& column) {
  for (Eigen::Index j = 0; j < set.cols(); ++j) {
    if (set.col(j) == column) return true;
  }
  return false;
}

void append_column(IndexBatch& set, const Eigen::VectorXi& column) {
  set.conservativeResize(column.size(), set.cols() + 1);
  set.col(set.cols() - 1) = column;
}

/// X with X P = T, for a square P whose pivots were chosen above a tolerance; its small directions, rounding,
/// are left out.
Eigen::MatrixXd right_quotient(const Eigen::MatrixXd& T, const Eigen::MatrixXd& P) {
  constexpr double kRounding = 1e-14;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(kRounding);
  decomposition.compute(P.transpose());
  return decomposition.solve(T.transpose()).transpose();
}

}  // namespace

GrowingCross::GrowingCross(SampleTable& table, std::vector<int> nodes, int max_rank, std::uint64_t seed)
    : table_(table), nodes_(std::move(nodes)), max_rank_(max_rank), random_(seed) {
  // The first pivot must not be zero: the largest value of a few random nodes.
  constexpr int kTrials = 10;
  IndexBatch trials(coordinates(), kTrials);
  for (int j = 0; j < kTrials; ++j) {
    for (int k = 0; k < coordinates(); ++k) {
      trials(k, j) = random_.below(nodes_[static_cast<std::size_t>(k)]);
    }
  }
  const std::vector<int> places = table_.places(trials);
  const Eigen::VectorXd scale = table_.function().scale();
  double largest = -1.0;
  Eigen::Index best = 0, output = 0;
  for (Eigen::Index j = 0; j < kTrials; ++j) {
    Eigen::Index m = 0;
    const double size =
        table_.values(places[static_cast<std::size_t>(j)]).cwiseQuotient(scale).cwiseAbs().maxCoeff(&m);
    if (size > largest) {
      largest = size;
      best = j;
      output = m;
    }
  }
  for (int b = 0; b < bonds(); ++b) {
    Eigen::VectorXi row(1 + b);
    row << static_cast<int>(output), trials.col(best).head(b);
    bonds_.push_back({row, trials.col(best).tail(coordinates() - b)});
  }
}

std::vector<int> GrowingCross::ranks() const {
  std::vector<int> ranks;
  for (const Bond& bond : bonds_) ranks.push_back(static_cast<int>(bond.cols.cols()));
  return ranks;
}

/// Rows of the bond before with every node of the mode between: bond 0 has the outputs. Behind the last bond
/// they are the rows of the last core.
IndexBatch GrowingCross::candidate_rows(int bond) const {
  if (bond == 0)
    return Eigen::RowVectorXi::LinSpaced(table_.function().outputs(), 0, table_.function().outputs() - 1);
  const IndexBatch& before = bonds_[static_cast<std::size_t>(bond) - 1].rows;
  const int n = nodes_[static_cast<std::size_t>(bond) - 1];
  IndexBatch rows(before.rows() + 1, before.cols() * n);
  for (int i = 0; i < n; ++i) {
    rows.middleCols(i * before.cols(), before.cols()) << before,
        Eigen::RowVectorXi::Constant(before.cols(), i);
  }
  return rows;
}

/// Every node of the mode behind the bond with the columns of the next bond.
IndexBatch GrowingCross::candidate_cols(int bond) const {
  const int n = nodes_[static_cast<std::size_t>(bond)];
  if (bond + 1 == bonds()) return Eigen::RowVectorXi::LinSpaced(n, 0, n - 1);
  const IndexBatch& behind = bonds_[static_cast<std::size_t>(bond) + 1].cols;
  IndexBatch cols(behind.rows() + 1, behind.cols() * n);
  for (Eigen::Index j = 0; j < behind.cols(); ++j) {
    cols.middleCols(j * n, n) << Eigen::RowVectorXi::LinSpaced(n, 0, n - 1), behind.col(j).replicate(1, n);
  }
  return cols;
}

/// Values at rows x cols over the scale of the row's output.
Eigen::MatrixXd GrowingCross::block(const IndexBatch& rows, const IndexBatch& cols) {
  const Eigen::Index before = rows.rows() - 1;
  // Rows of bond 0 differ in their output only: one point serves them all.
  const Eigen::Index prefixes = before == 0 ? 1 : rows.cols();
  IndexBatch points(coordinates(), prefixes * cols.cols());
  for (Eigen::Index c = 0; c < cols.cols(); ++c) {
    for (Eigen::Index p = 0; p < prefixes; ++p) {
      points.col(c * prefixes + p) << rows.col(p).tail(before), cols.col(c);
    }
  }
  const std::vector<int> places = table_.places(points);
  const Eigen::VectorXd scale = table_.function().scale();
  Eigen::MatrixXd values(rows.cols(), cols.cols());
  for (Eigen::Index c = 0; c < cols.cols(); ++c) {
    for (Eigen::Index r = 0; r < rows.cols(); ++r) {
      const auto place = static_cast<std::size_t>(c * prefixes + (before == 0 ? 0 : r));
      values(r, c) = table_.value(rows(0, r), places[place]) / scale[rows(0, r)];
    }
  }
  return values;
}

void GrowingCross::append(Bond& bond, const Eigen::VectorXi& row, const Eigen::VectorXi& col) {
  append_column(bond.rows, row);
  append_column(bond.cols, col);
}

/// One pivot more at a bond, by rook search: the largest error of a random column, then of that row, then of
/// that column. @returns false if the search ends at an error within the tolerance
bool GrowingCross::grow_bond(int b, double tolerance) {
  Bond& bond = bonds_[static_cast<std::size_t>(b)];
  const IndexBatch rows = candidate_rows(b);
  const IndexBatch cols = candidate_cols(b);
  if (bond.cols.cols() >= std::min(rows.cols(), cols.cols())) return false;
  if (bond.cols.cols() >= max_rank_) {
    exhausted_ = true;
    return false;
  }
  const Eigen::MatrixXd left = right_quotient(block(rows, bond.cols), block(bond.rows, bond.cols));
  const Eigen::MatrixXd right = block(bond.rows, cols);
  Eigen::Index row = -1;
  Eigen::Index col = random_.below(static_cast<int>(cols.cols()));
  double error = 0.0;
  for (int step = 0; step < kRookSteps; ++step) {
    const Eigen::VectorXd in_column = block(rows, cols.col(col)).col(0) - left * right.col(col);
    Eigen::Index best = 0;
    error = in_column.cwiseAbs().maxCoeff(&best);
    if (best == row) break;
    row = best;
    const Eigen::RowVectorXd in_row = block(rows.col(row), cols).row(0) - left.row(row) * right;
    error = in_row.cwiseAbs().maxCoeff(&best);
    if (best == col) break;
    col = best;
  }
  if (!(error > tolerance)) return false;
  if (has_column(bond.rows, rows.col(row)) || has_column(bond.cols, cols.col(col))) return false;
  append(bond, rows.col(row), cols.col(col));
  return true;
}

void GrowingCross::grow(double tolerance, long max_calls) {
  bool added = true;
  while (added && table_.function().calls() <= max_calls) {
    added = false;
    for (int b = 0; b < bonds(); ++b) added = grow_bond(b, tolerance) || added;
  }
}

int GrowingCross::add_pivot(const Eigen::VectorXi& point, double tolerance) {
  const std::vector<int> place = table_.places(point);
  int taken = 0;
  for (int b = 0; b < bonds(); ++b) {
    Bond& bond = bonds_[static_cast<std::size_t>(b)];
    if (bond.cols.cols() >= max_rank_) {
      exhausted_ = true;
      continue;
    }
    const Eigen::VectorXi col = point.tail(coordinates() - b);
    // Any output may be the row's: at bond 0 all of them, behind it those that its pivots have.
    IndexBatch rows(1 + b, table_.function().outputs());
    rows << Eigen::RowVectorXi::LinSpaced(table_.function().outputs(), 0, table_.function().outputs() - 1),
        point.head(b).replicate(1, table_.function().outputs());
    if (has_column(bond.cols, col)) continue;
    const Eigen::MatrixXd left = right_quotient(block(rows, bond.cols), block(bond.rows, bond.cols));
    const Eigen::VectorXd error = block(rows, col).col(0) - left * block(bond.rows, col).col(0);
    Eigen::Index m = 0;
    if (!(error.cwiseAbs().maxCoeff(&m) > tolerance) || has_column(bond.rows, rows.col(m))) continue;
    append(bond, rows.col(m), col);
    ++taken;
  }
  return taken;
}

TensorTrain GrowingCross::train() {
  TensorTrain train;
  for (int k = 0; k <= coordinates(); ++k) {
    // T_k with rows (row of bond k-1, node of mode k), the row running fastest: a left unfolding.
    const bool last = k == coordinates();
    const IndexBatch rows = candidate_rows(k);
    const IndexBatch cols = last ? IndexBatch(0, 1) : bonds_[static_cast<std::size_t>(k)].cols;
    Eigen::MatrixXd values = block(rows, cols);
    if (!last) values = right_quotient(values, block(bonds_[static_cast<std::size_t>(k)].rows, cols));
    const int left = k == 0 ? 1 : static_cast<int>(bonds_[static_cast<std::size_t>(k) - 1].rows.cols());
    const int size = k == 0 ? table_.function().outputs() : nodes_[static_cast<std::size_t>(k) - 1];
    TrainCore core(left, size, static_cast<int>(cols.cols()));
    core.left_unfolding() = values;
    train.cores.push_back(std::move(core));
  }
  // Back to the outputs' own units.
  train.cores[0].left_unfolding() = table_.function().scale().asDiagonal() * train.cores[0].left_unfolding();
  return train;
}

Eigen::MatrixXd GrowingCross::pivots() const {
  IndexBatch points(coordinates(), 0);
  for (const Bond& bond : bonds_) {
    for (Eigen::Index r = 0; r < bond.rows.cols(); ++r) {
      Eigen::VectorXi point(coordinates());
      point << bond.rows.col(r).tail(bond.rows.rows() - 1), bond.cols.col(r);
      if (!has_column(points, point)) append_column(points, point);
    }
  }
  Eigen::MatrixXd x(points.rows(), points.cols());
  for (Eigen::Index j = 0; j < points.cols(); ++j) x.col(j) = table_.point(points.col(j));
  return x;
}

}  // namespace samara::pgd
