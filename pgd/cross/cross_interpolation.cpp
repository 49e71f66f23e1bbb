#include "samara/pgd/cross/cross_interpolation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/cross/entry_table.h"
#include "samara/pgd/cross/max_volume.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

constexpr int kRandomPivots = 2;
constexpr int kGuardPivots = 4;
/// Of the tolerance: entries that a skeleton may leave out.
constexpr double kNegligible = 0.1;

/// Columns of `set` and `more` without duplicates, at most `max_rank` of them.
void add_columns(IndexBatch& set, const IndexBatch& more, int max_rank) {
  for (Eigen::Index j = 0; j < more.cols() && set.cols() < max_rank; ++j) {
    bool known = false;
    for (Eigen::Index i = 0; i < set.cols() && !known; ++i) known = set.col(i) == more.col(j);
    if (known) continue;
    set.conservativeResize(more.rows(), set.cols() + 1);
    set.col(set.cols() - 1) = more.col(j);
  }
}

/// The running state of one interpolation. Mode 0 is the list of outputs; the grid's modes follow.
class Cross {
 public:
  Cross(const EntryFunction& function, int outputs, const std::vector<int>& sizes,
        const CrossOptions& options)
      : options_(options),
        outputs_(outputs),
        sizes_(sizes),
        table_(function, outputs, sizes),
        random_(options.seed) {
    const std::size_t d = sizes.size();
    left_.resize(d + 2);
    right_.resize(d + 1);
    // All outputs are carried through: one call gives them all.
    left_[1] = Eigen::RowVectorXi::LinSpaced(outputs, 0, outputs - 1);
    for (std::size_t k = 1; k < d; ++k) {
      right_[k] = k < options.start.right.size() ? options.start.right[k] : IndexBatch();
      add_columns(right_[k], random_entries(k, options_.first_pivots), options_.max_rank);
    }
    right_[d] = IndexBatch(0, 1);
    if (options.state) {
      right_ = options.state->pivots.right;
      random_ = options.state->random;
      evaluated_before_ = options.state->evaluations;
      largest_before_ = options.state->largest;
    }
    cores_.resize(d + 1);
    cores_[0] = TrainCore(1, outputs, outputs);
    cores_[0].left_unfolding().setIdentity();
  }

  CrossResult run() {
    CrossResult result;
    if (options_.state) result.sweeps = options_.state->sweeps;
    while (true) {
      ++result.sweeps;
      for (std::size_t k = 1; k < modes(); ++k) step_right(k);
      for (std::size_t k = modes(); k > 1; --k) step_left(k);
      cores_[1] = block(1);
      if (finished(result)) break;
      for (std::size_t k = 1; k < modes(); ++k) {
        const int half = half_growth(right_[k]);
        const Eigen::Index worst = std::min<Eigen::Index>(worst_.cols(), std::max(kGuardPivots, half));
        add_columns(right_[k], random_entries(k, std::max(kRandomPivots, half)), options_.max_rank);
        add_columns(right_[k], worst_.bottomRows(static_cast<Eigen::Index>(modes() - k)).leftCols(worst),
                    options_.max_rank);
      }
      if (!options_.checkpoint) continue;
      CrossState state{{right_}, random_, result.sweeps, evaluations(), largest()};
      table_.forget();
      options_.checkpoint(state);
    }
    result.train.cores = cores_;
    result.largest = largest();
    result.evaluations = evaluations();
    result.grid_size = std::accumulate(sizes_.begin(), sizes_.end(), 1.0, std::multiplies<>());
    result.pivots.right = right_;
    result.bad_entry = table_.bad_entry();
    return result;
  }

 private:
  std::size_t modes() const { return sizes_.size(); }
  long evaluations() const { return evaluated_before_ + table_.evaluations(); }
  double largest() const { return std::max(largest_before_, table_.largest()); }
  int mode_size(std::size_t k) const { return sizes_[k - 1]; }

  int half_growth(const IndexBatch& set) const {
    return static_cast<int>(0.5 * options_.growth * static_cast<double>(set.cols()));
  }

  /// Random indices over the modes after mode k.
  IndexBatch random_entries(std::size_t k, int count) {
    IndexBatch entries(static_cast<Eigen::Index>(modes() - k), count);
    for (int j = 0; j < count; ++j) {
      for (std::size_t m = k; m < modes(); ++m)
        entries(static_cast<Eigen::Index>(m - k), j) = random_.below(sizes_[m]);
    }
    return entries;
  }

  /// Values on left set x mode k x right set, as a core. Members of the left set that differ by their outputs only
  /// share entries.
  TrainCore block(std::size_t k) {
    const IndexBatch& left = left_[k];
    const IndexBatch& right = right_[k];
    const int n = mode_size(k);
    TrainCore core(static_cast<int>(left.cols()), n, static_cast<int>(right.cols()));
    const auto before = static_cast<Eigen::Index>(k) - 1;  // grid modes before mode k
    const std::vector<std::vector<int>> places = members_by_place(left.bottomRows(before));
    const auto count = static_cast<Eigen::Index>(places.size());
    IndexBatch entries(static_cast<Eigen::Index>(modes()), count * n * right.cols());
    Eigen::Index j = 0;
    for (Eigen::Index r = 0; r < right.cols(); ++r) {
      for (int i = 0; i < n; ++i) {
        for (const std::vector<int>& members : places) {
          entries.col(j).head(before) = left.col(members.front()).tail(before);
          entries(before, j) = i;
          entries.col(j).tail(right.rows()) = right.col(r);
          ++j;
        }
      }
    }
    table_.visit(entries, [&](Eigen::Index entry, const double* values) {
      for (const int l : places[static_cast<std::size_t>(entry % count)])
        core.data[l + core.left * (entry / count)] = values[left(0, l)];
    });
    return core;
  }

  /// Columns that are the same.
  static std::vector<std::vector<int>> members_by_place(const IndexBatch& columns) {
    std::vector<std::vector<int>> places;
    std::map<std::vector<int>, std::size_t> known;
    for (int j = 0; j < columns.cols(); ++j) {
      const auto [place, is_new] =
          known.try_emplace({columns.col(j).begin(), columns.col(j).end()}, places.size());
      if (is_new) places.emplace_back();
      places[place->second].push_back(j);
    }
    return places;
  }

  /// Columns that span the others up to a small part of the tolerance, and rows to interpolate them in.
  MaxVolume skeleton(const Eigen::MatrixXd& matrix, const std::vector<int>& groups = {}) const {
    return max_volume(matrix, options_.max_rank, kNegligible * options_.tolerance, groups);
  }

  /// Of the rows of the left unfolding of block k, where they are: outputs at the same place come from one entry. Empty
  /// where that does not matter.
  std::vector<int> places_of_rows(std::size_t k) const {
    if (outputs_ == 1 || !options_.few_places) return {};
    const std::vector<std::vector<int>> places = members_by_place(left_[k].bottomRows(left_[k].rows() - 1));
    const auto count = static_cast<int>(places.size());
    const auto members = static_cast<std::size_t>(left_[k].cols());
    std::vector<int> of_rows(members * static_cast<std::size_t>(mode_size(k)));
    for (int i = 0; i < mode_size(k); ++i) {
      for (int place = 0; place < count; ++place) {
        for (const int l : places[static_cast<std::size_t>(place)])
          of_rows[static_cast<std::size_t>(i) * members + static_cast<std::size_t>(l)] = place + count * i;
      }
    }
    return of_rows;
  }

  /// Interpolates core k from the left and chooses the left set of the next core.
  void step_right(std::size_t k) {
    if (!table_.bad_entry().empty()) return;
    const TrainCore values = block(k);
    if (!table_.bad_entry().empty()) return;
    const MaxVolume best = skeleton(values.left_unfolding(), places_of_rows(k));
    const Eigen::Index rank = best.coefficients.cols();
    left_[k + 1].resize(static_cast<Eigen::Index>(k) + 1, rank);
    for (Eigen::Index r = 0; r < rank; ++r) {
      const int row = best.rows[static_cast<std::size_t>(r)];
      left_[k + 1].col(r).head(static_cast<Eigen::Index>(k)) = left_[k].col(row % values.left);
      left_[k + 1](static_cast<Eigen::Index>(k), r) = row / values.left;
    }
  }

  /// Interpolates core k from the right and chooses the right set of the core before.
  void step_left(std::size_t k) {
    if (!table_.bad_entry().empty()) return;
    const TrainCore values = block(k);
    if (!table_.bad_entry().empty()) return;
    const MaxVolume best = skeleton(values.right_unfolding().transpose());
    const Eigen::Index rank = best.coefficients.cols();
    IndexBatch set(static_cast<Eigen::Index>(modes() - k) + 1, rank);
    for (Eigen::Index r = 0; r < rank; ++r) {
      const int column = best.rows[static_cast<std::size_t>(r)];
      set(0, r) = column % values.size;
      set.col(r).tail(set.rows() - 1) = right_[k].col(column / values.size);
    }
    right_[k - 1] = std::move(set);
    cores_[k] = TrainCore(static_cast<int>(rank), values.size, values.right);
    cores_[k].right_unfolding() = best.coefficients.transpose();
  }

  bool finished(CrossResult& result) {
    result.guard_error = table_.bad_entry().empty() ? guard() : std::numeric_limits<double>::infinity();
    if (!table_.bad_entry().empty()) {
      result.status = Termination::not_finite;
      result.message =
          fmt::format("the function is not finite at entry ({})", fmt::join(table_.bad_entry(), ", "));
      return true;
    }
    const std::string figures = fmt::format("guard error {:.3g} after {} sweeps and {} evaluations",
                                            result.guard_error, result.sweeps, evaluations());
    if (result.guard_error <= options_.tolerance) {
      result.status = Termination::converged;
      result.message = figures;
      return true;
    }
    if (result.sweeps >= options_.max_sweeps || evaluations() >= options_.max_evaluations) {
      result.status =
          result.sweeps >= options_.max_sweeps ? Termination::max_iterations : Termination::max_calls;
      result.message = fmt::format("{} > {:.3g}", figures, options_.tolerance);
      return true;
    }
    return false;
  }

  /// Compares the train with fresh random entries; keeps the worst as pivots.
  double guard() {
    TensorTrain train;
    train.cores = cores_;
    const IndexBatch entries = random_entries(0, options_.guard_entries);
    const Eigen::MatrixXd exact = table_.fetch(entries);
    if (!table_.bad_entry().empty()) return std::numeric_limits<double>::infinity();
    const Eigen::VectorXd error = (values_at(train, entries) - exact).cwiseAbs().colwise().maxCoeff();
    std::vector<int> order(static_cast<std::size_t>(entries.cols()));
    std::iota(order.begin(), order.end(), 0);
    int most = kGuardPivots;
    for (const IndexBatch& set : right_) most = std::max(most, half_growth(set));
    const auto kept = std::min<std::ptrdiff_t>(most, static_cast<std::ptrdiff_t>(order.size()));
    std::partial_sort(order.begin(), order.begin() + kept, order.end(),
                      [&](int a, int b) { return error[a] > error[b]; });
    order.resize(static_cast<std::size_t>(kept));
    worst_ = entries(Eigen::all, order);
    return error.maxCoeff();
  }

  const CrossOptions& options_;
  int outputs_;
  const std::vector<int>& sizes_;
  EntryTable table_;
  long evaluated_before_ = 0;  ///< by an interpolation that was interrupted
  double largest_before_ = 0.0;
  Random random_;
  std::vector<IndexBatch> left_;   ///< left_[k]: output and grid modes before mode k, one column per index
  std::vector<IndexBatch> right_;  ///< right_[k]: grid modes after mode k
  std::vector<TrainCore> cores_;
  IndexBatch worst_;
};

void check_pivots(const CrossPivots& pivots, const std::vector<int>& sizes) {
  for (std::size_t k = 0; k < pivots.right.size(); ++k) {
    const IndexBatch& set = pivots.right[k];
    if (set.cols() == 0) continue;
    bool fits = k <= sizes.size() && set.rows() == static_cast<Eigen::Index>(sizes.size() - k);
    for (Eigen::Index m = 0; fits && m < set.rows(); ++m) {
      fits = set.row(m).minCoeff() >= 0 && set.row(m).maxCoeff() < sizes[k + static_cast<std::size_t>(m)];
    }
    if (!fits) {
      throw ArgumentError(fmt::format("the start's pivots after mode {} do not lie on the grid of {} nodes",
                                      k, fmt::join(sizes, " x ")));
    }
  }
}

}  // namespace

void add_entries(CrossPivots& pivots, const IndexBatch& entries, int max_rank) {
  for (IndexBatch& set : pivots.right)
    if (set.rows() > 0) add_columns(set, entries.bottomRows(set.rows()), max_rank);
}

CrossPivots carried_over(CrossPivots pivots, const std::vector<int>& from, const std::vector<int>& to) {
  for (std::size_t k = 0; k < pivots.right.size(); ++k) {
    IndexBatch& set = pivots.right[k];
    for (Eigen::Index m = 0; m < set.rows(); ++m) {
      const std::size_t mode = k + static_cast<std::size_t>(m);
      const double ratio = static_cast<double>(to[mode] - 1) / std::max(1, from[mode] - 1);
      for (Eigen::Index j = 0; j < set.cols(); ++j)
        set(m, j) = static_cast<int>(std::lround(set(m, j) * ratio));
    }
  }
  return pivots;
}

CrossResult interpolate(const EntryFunction& function, int outputs, const std::vector<int>& sizes,
                        const CrossOptions& options) {
  constexpr std::string_view kWhere = "cross interpolation";
  require(outputs >= 1, "the number of outputs", outputs, "at least 1", kWhere);
  require(!sizes.empty(), "the number of modes", sizes.size(), "at least 1", kWhere);
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    require(sizes[k] >= 1, fmt::format("the size of mode {}", k), sizes[k], "at least 1", kWhere);
  }
  require(options.tolerance > 0.0, "tolerance", options.tolerance, "more than 0", kWhere);
  require(options.max_rank >= 1, "max_rank", options.max_rank, "at least 1", kWhere);
  require(options.max_sweeps >= 1, "max_sweeps", options.max_sweeps, "at least 1", kWhere);
  require(options.first_pivots >= 1, "first_pivots", options.first_pivots, "at least 1", kWhere);
  require(options.growth >= 0.0, "growth", options.growth, "at least 0", kWhere);
  require(options.guard_entries >= 1, "guard_entries", options.guard_entries, "at least 1", kWhere);
  check_pivots(options.start, sizes);
  if (options.state) {
    check_pivots(options.state->pivots, sizes);
    require(options.state->pivots.right.size() == sizes.size() + 1,
            "the number of sets of a state to go on from", options.state->pivots.right.size(),
            "one more than there are modes", kWhere);
  }
  return Cross(function, outputs, sizes, options).run();
}

}  // namespace samara::pgd
