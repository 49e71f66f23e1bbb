#include "samara/pgd/tensors/train_points.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "samara/base/parallel.h"
#include "samara/pgd/tensors/train_algebra.h"

namespace samara::pgd {

Eigen::MatrixXd values_at(const TensorTrain& train, const IndexBatch& entries) {
  const std::size_t modes = train.cores.size() - 1;
  Eigen::MatrixXd values(train.cores[0].size, entries.cols());
  // after[k]: the product of the cores of mode k and all after it, at the present entry.
  std::vector<Eigen::VectorXd> after(modes + 1, Eigen::VectorXd::Ones(1));
  for (Eigen::Index j = 0; j < entries.cols(); ++j) {
    std::size_t known = modes;  // modes from here on are those of the entry before
    while (j > 0 && known > 0 &&
           entries(static_cast<Eigen::Index>(known) - 1, j) ==
               entries(static_cast<Eigen::Index>(known) - 1, j - 1))
      --known;
    for (std::size_t k = known; k-- > 0;) {
      after[k].noalias() = train.cores[k + 1].slice(entries(static_cast<Eigen::Index>(k), j)) * after[k + 1];
    }
    values.col(j).noalias() = train.cores[0].left_unfolding() * after[0];
  }
  return values;
}

Eigen::MatrixXd values_at(const TensorTrain& train, const std::vector<Axis>& axes,
                          const Eigen::MatrixXd& points) {
  Eigen::MatrixXd values(train.cores[0].size, points.cols());
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    Eigen::VectorXd after = Eigen::VectorXd::Ones(1);
    for (std::size_t k = axes.size(); k-- > 0;) {
      InterpolationStencil stencil = axes[k].make_stencil();
      axes[k].interpolate(points(static_cast<Eigen::Index>(k), j), stencil, false);
      Eigen::VectorXd next = Eigen::VectorXd::Zero(train.cores[k + 1].left);
      for (Eigen::Index i = 0; i < stencil.value.size(); ++i) {
        next.noalias() +=
            stencil.value[i] * (train.cores[k + 1].slice(stencil.first + static_cast<int>(i)) * after);
      }
      after = std::move(next);
    }
    values.col(j).noalias() = train.cores[0].left_unfolding() * after;
  }
  return values;
}

namespace {

/// Sets after(:, j) to the core at the place of point j times after(:, j). Of a core, the nodes of elements in which
/// there are points are read.
void go_through(const TrainCore& core, const Axis& axis, const Eigen::Ref<const Eigen::RowVectorXd>& places,
                Eigen::MatrixXd& after) {
  const Eigen::Index count = places.size(), left = core.left, width = axis.stencil_size();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(count)), firsts(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  Eigen::MatrixXd weights(width, count);
  InterpolationStencil stencil = axis.make_stencil();
  for (Eigen::Index j = 0; j < count; ++j) {
    axis.interpolate(places[j], stencil, false);
    weights.col(j) = stencil.value;
    firsts[static_cast<std::size_t>(j)] = stencil.first;
  }
  const auto first_of = [&](Eigen::Index j) { return firsts[static_cast<std::size_t>(j)]; };
  std::ranges::stable_sort(order, {}, first_of);
  Eigen::MatrixXd before(left, count);
  for (auto begin = order.cbegin(); begin != order.cend();) {
    const Eigen::Index first = first_of(*begin);
    const auto end = std::find_if(begin, order.cend(), [&](Eigen::Index j) { return first_of(j) != first; });
    const std::vector<Eigen::Index> together(begin, end);
    const Eigen::MatrixXd at_nodes =
        core.left_unfolding().middleRows(left * first, left * width) * after(Eigen::all, together);
    for (std::size_t m = 0; m < together.size(); ++m)
      before.col(together[m]).noalias() =
          at_nodes.col(static_cast<Eigen::Index>(m)).reshaped(left, width) * weights.col(together[m]);
    begin = end;
  }
  after = std::move(before);
}

}  // namespace

Eigen::MatrixXd many_values_at(const TensorTrain& train, const std::vector<Axis>& axes,
                               const Eigen::MatrixXd& points) {
  constexpr Eigen::Index kTogether = 64;
  Eigen::MatrixXd values(train.cores[0].size, points.cols());
  parallel_for((points.cols() + kTogether - 1) / kTogether, [&](Eigen::Index block) {
    const Eigen::Index first = block * kTogether, count = std::min(kTogether, points.cols() - first);
    Eigen::MatrixXd after = Eigen::MatrixXd::Ones(1, count);
    for (std::size_t k = axes.size(); k-- > 0;)
      go_through(train.cores[k + 1], axes[k], points.row(static_cast<Eigen::Index>(k)).segment(first, count),
                 after);
    values.middleCols(first, count).noalias() = train.cores[0].left_unfolding() * after;
  });
  return values;
}

Eigen::MatrixXd interpolation_matrix(const Axis& from, const Eigen::VectorXd& points) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(points.size(), from.size());
  InterpolationStencil stencil = from.make_stencil();
  for (Eigen::Index i = 0; i < points.size(); ++i) {
    from.interpolate(points[i], stencil, false);
    matrix.block(i, stencil.first, 1, stencil.value.size()) = stencil.value.transpose();
  }
  return matrix;
}

TensorTrain carried_over(TensorTrain train, const std::vector<Axis>& from, const std::vector<Axis>& to) {
  for (std::size_t k = 0; k < from.size(); ++k) {
    const bool same = from[k].size() == to[k].size() && from[k].nodes() == to[k].nodes();
    if (same) continue;
    train = applied(std::move(train), static_cast<int>(k) + 1, interpolation_matrix(from[k], to[k].nodes()));
  }
  return train;
}

}  // namespace samara::pgd
