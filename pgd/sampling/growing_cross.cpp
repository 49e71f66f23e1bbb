#include "samara/pgd/sampling/growing_cross.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include <Eigen/QR>

namespace samara::pgd {

namespace {

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
  if (!grid_ranks_.empty()) return grid_ranks_;
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

/// Every node of the mode after the bond with the columns of the next bond.
IndexBatch GrowingCross::candidate_cols(int bond) const {
  const int n = nodes_[static_cast<std::size_t>(bond)];
  if (bond + 1 == bonds()) return Eigen::RowVectorXi::LinSpaced(n, 0, n - 1);
  const IndexBatch& after = bonds_[static_cast<std::size_t>(bond) + 1].cols;
  IndexBatch cols(after.rows() + 1, after.cols() * n);
  for (Eigen::Index j = 0; j < after.cols(); ++j) {
    cols.middleCols(j * n, n) << Eigen::RowVectorXi::LinSpaced(n, 0, n - 1), after.col(j).replicate(1, n);
  }
  return cols;
}

/// Points of a block, without the outputs: rows run fastest. Rows of bond 0 differ in their output only, so
/// that one point serves them all.
IndexBatch GrowingCross::points_of(const Block& block) const {
  const Eigen::Index before = block.rows.rows() - 1;
  const Eigen::Index prefixes = before == 0 ? 1 : block.rows.cols();
  IndexBatch points(coordinates(), prefixes * block.cols.cols());
  for (Eigen::Index c = 0; c < block.cols.cols(); ++c) {
    for (Eigen::Index p = 0; p < prefixes; ++p) {
      points.col(c * prefixes + p) << block.rows.col(p).tail(before), block.cols.col(c);
    }
  }
  return points;
}

std::vector<Eigen::MatrixXd> GrowingCross::values(const std::vector<Block>& blocks) {
  std::vector<IndexBatch> parts;
  Eigen::Index count = 0;
  for (const Block& block : blocks) count += parts.emplace_back(points_of(block)).cols();
  IndexBatch points(coordinates(), count);
  Eigen::Index first = 0;
  for (const IndexBatch& part : parts) {
    points.middleCols(first, part.cols()) = part;
    first += part.cols();
  }
  const std::vector<int> places = table_.places(points);
  const Eigen::VectorXd scale = table_.function().scale();
  std::vector<Eigen::MatrixXd> values;
  auto place = places.begin();
  for (const Block& block : blocks) {
    const bool shared = block.rows.rows() == 1;
    Eigen::MatrixXd& table = values.emplace_back(block.rows.cols(), block.cols.cols());
    for (Eigen::Index c = 0; c < table.cols(); ++c) {
      for (Eigen::Index r = 0; r < table.rows(); ++r) {
        const int output = block.rows(0, r);
        table(r, c) = table_.value(output, *place) / scale[output];
        if (!shared) ++place;
      }
      if (shared) ++place;
    }
  }
  return values;
}

void GrowingCross::append(Bond& bond, const Eigen::VectorXi& row, const Eigen::VectorXi& col) {
  append_column(bond.rows, row);
  append_column(bond.cols, col);
}

/// At every bond that has room for a pivot: the interpolant of its candidates, and in a random column the
/// row with the largest error.
std::vector<GrowingCross::Search> GrowingCross::searches() {
  std::vector<Search> searches;
  std::vector<Block> wanted;
  for (int b = 0; b < bonds(); ++b) {
    const Bond& bond = bonds_[static_cast<std::size_t>(b)];
    IndexBatch rows = candidate_rows(b);
    IndexBatch cols = candidate_cols(b);
    if (bond.cols.cols() >= std::min(rows.cols(), cols.cols())) continue;
    if (bond.cols.cols() >= max_rank_) {
      exhausted_ = true;
      continue;
    }
    const Eigen::Index start = random_.below(static_cast<int>(cols.cols()));
    wanted.push_back({rows, bond.cols});
    wanted.push_back({bond.rows, bond.cols});
    wanted.push_back({bond.rows, cols});
    wanted.push_back({rows, cols.col(start)});
    searches.push_back({.bond = b, .rows = std::move(rows), .cols = std::move(cols), .col = start});
  }
  const std::vector<Eigen::MatrixXd> blocks = values(wanted);
  auto block = blocks.begin();
  for (Search& search : searches) {
    search.left = right_quotient(block[0], block[1]);
    search.right = block[2];
    const Eigen::VectorXd errors = block[3] - search.left * search.right.col(search.col);
    errors.cwiseAbs().maxCoeff(&search.row);
    block += 4;
  }
  return searches;
}

/// Moves every search to the largest error in its row.
void GrowingCross::look_along_rows(std::vector<Search>& searches) {
  std::vector<Block> wanted;
  for (const Search& search : searches) wanted.push_back({search.rows.col(search.row), search.cols});
  const std::vector<Eigen::MatrixXd> blocks = values(wanted);
  auto block = blocks.begin();
  for (Search& search : searches) {
    const Eigen::RowVectorXd errors = *block++ - search.left.row(search.row) * search.right;
    search.error = errors.cwiseAbs().maxCoeff(&search.col);
  }
}

/// One pivot more at every bond at which the search finds an error above the tolerance. @returns whether
/// there was one
bool GrowingCross::grow_once(double tolerance) {
  std::vector<Search> found = searches();
  look_along_rows(found);
  bool grown = false;
  for (const Search& search : found) {
    Bond& bond = bonds_[static_cast<std::size_t>(search.bond)];
    const auto row = search.rows.col(search.row);
    const auto col = search.cols.col(search.col);
    if (!(search.error > tolerance) || has_column(bond.rows, row) || has_column(bond.cols, col)) continue;
    append(bond, row, col);
    grown = true;
  }
  return grown;
}

/// Below so many nodes nobody knows yet how many ranks there will be.
bool GrowingCross::has_called_most() const {
  constexpr double kMost = 0.7;
  constexpr double kFew = 49.0;
  if (coordinates() == 1) return true;
  const double grid = static_cast<double>(nodes_[0]) * nodes_[1];
  return coordinates() == 2 && grid >= kFew && static_cast<double>(table_.size()) >= kMost * grid;
}

void GrowingCross::grow(double tolerance, long max_calls) {
  tolerance_ = tolerance;
  const auto takes_whole_grid = [&] { return has_whole_grid_ = has_whole_grid_ || has_called_most(); };
  while (!takes_whole_grid() && table_.function().calls() <= max_calls && grow_once(tolerance)) continue;
  if (!has_whole_grid_) return;
  exhausted_ = false;
  table_.places(all_nodes());
}

/// The first coordinate runs fastest.
IndexBatch GrowingCross::all_nodes() const {
  IndexBatch points(coordinates(), std::accumulate(nodes_.begin(), nodes_.end(), 1, std::multiplies<>()));
  int stride = 1;
  for (int k = 0; k < coordinates(); ++k) {
    const int n = nodes_[static_cast<std::size_t>(k)];
    for (int j = 0; j < points.cols(); ++j) points(k, j) = j / stride % n;
    stride *= n;
  }
  return points;
}

int GrowingCross::add_pivot(const Eigen::VectorXi& point, double tolerance) {
  if (has_whole_grid_) return 0;
  const int outputs = table_.function().outputs();
  std::vector<Search> open;
  std::vector<Block> crosses;
  for (int b = 0; b < bonds(); ++b) {
    const Bond& bond = bonds_[static_cast<std::size_t>(b)];
    if (bond.cols.cols() >= max_rank_) {
      exhausted_ = true;
      continue;
    }
    IndexBatch col = point.tail(coordinates() - b);
    if (has_column(bond.cols, col)) continue;
    // Any output may be the row's: at bond 0 all of them, after it those that its pivots have.
    IndexBatch rows(1 + b, outputs);
    rows << Eigen::RowVectorXi::LinSpaced(outputs, 0, outputs - 1), point.head(b).replicate(1, outputs);
    crosses.push_back({rows, bond.cols});
    crosses.push_back({bond.rows, bond.cols});
    crosses.push_back({bond.rows, col});
    crosses.push_back({rows, col});
    open.push_back({.bond = b, .rows = std::move(rows), .cols = std::move(col)});
  }
  const std::vector<Eigen::MatrixXd> blocks = values(crosses);
  int taken = 0;
  for (std::size_t s = 0; s < open.size(); ++s) {
    Bond& bond = bonds_[static_cast<std::size_t>(open[s].bond)];
    const Eigen::MatrixXd left = right_quotient(blocks[4 * s], blocks[4 * s + 1]);
    const Eigen::VectorXd error = blocks[4 * s + 3].col(0) - left * blocks[4 * s + 2].col(0);
    Eigen::Index m = 0;
    if (!(error.cwiseAbs().maxCoeff(&m) > tolerance) || has_column(bond.rows, open[s].rows.col(m))) continue;
    append(bond, open[s].rows.col(m), open[s].cols.col(0));
    ++taken;
  }
  return taken;
}

TensorTrain GrowingCross::train_of_grid() {
  // Of the search's tolerance, what the mean square over all values may lose: single ones lose more.
  constexpr double kShare = 0.05;
  const std::vector<int> places = table_.places(all_nodes());
  const Eigen::VectorXd scale = table_.function().scale();
  Eigen::MatrixXd values(scale.size(), static_cast<Eigen::Index>(places.size()));
  for (Eigen::Index j = 0; j < values.cols(); ++j)
    values.col(j) = table_.values(places[static_cast<std::size_t>(j)]).cwiseQuotient(scale);
  TensorTrain train =
      to_train(values, nodes_, kShare * tolerance_ * std::sqrt(static_cast<double>(values.size())));
  grid_ranks_ = train.ranks();
  train.cores[0].left_unfolding() = scale.asDiagonal() * train.cores[0].left_unfolding();
  return train;
}

TensorTrain GrowingCross::train() {
  if (has_whole_grid_) return train_of_grid();
  // T_k with rows (row of bond k-1, node of mode k), the row running fastest: a left unfolding.
  std::vector<Block> wanted;
  for (int b = 0; b < bonds(); ++b) {
    const Bond& bond = bonds_[static_cast<std::size_t>(b)];
    wanted.push_back({candidate_rows(b), bond.cols});
    wanted.push_back({bond.rows, bond.cols});
  }
  wanted.push_back({candidate_rows(bonds()), IndexBatch(0, 1)});
  const std::vector<Eigen::MatrixXd> blocks = values(wanted);
  TensorTrain train;
  for (int k = 0; k <= coordinates(); ++k) {
    const auto at = 2 * static_cast<std::size_t>(k);
    const Eigen::MatrixXd unfolding =
        k == coordinates() ? blocks[at] : right_quotient(blocks[at], blocks[at + 1]);
    const int left = k == 0 ? 1 : static_cast<int>(bonds_[static_cast<std::size_t>(k) - 1].rows.cols());
    const int size = k == 0 ? table_.function().outputs() : nodes_[static_cast<std::size_t>(k) - 1];
    TrainCore core(left, size, static_cast<int>(unfolding.cols()));
    core.left_unfolding() = unfolding;
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
