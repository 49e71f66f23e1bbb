#include "samara/pgd/tensors/tensor_train.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/tensors/thin_qr.h"
#include "samara/pgd/tensors/thin_svd.h"

namespace samara::pgd {

namespace {

/// Unfolding (rank so far * size of the mode) x terms of `carry` (rank so far x terms) times the diagonal
/// core of one mode: the diagonal cores of size terms^2 n are never formed.
Eigen::MatrixXd carried_unfolding(const Eigen::MatrixXd& carry, const Eigen::MatrixXd& factor) {
  Eigen::MatrixXd unfolding = Eigen::MatrixXd::Zero(carry.rows() * factor.rows(), carry.cols());
  for (Eigen::Index r = 0; r < factor.cols(); ++r) {
    Eigen::Map<Eigen::MatrixXd>(unfolding.col(r).data(), carry.rows(), factor.rows()).noalias() =
        carry.col(r) * factor.col(r).transpose();
  }
  return unfolding;
}

/// Cores 1..d-1 made orthonormal from the left; the last one carries the norm.
void orthogonalise_left(TensorTrain& train) {
  for (std::size_t k = 0; k + 1 < train.cores.size(); ++k) {
    TrainCore& core = train.cores[k];
    Eigen::MatrixXd r;
    const Eigen::MatrixXd q = thin_qr(core.left_unfolding(), r);
    TrainCore next(static_cast<int>(r.rows()), train.cores[k + 1].size, train.cores[k + 1].right);
    next.right_unfolding() = r * train.cores[k + 1].right_unfolding();
    core = TrainCore(core.left, core.size, static_cast<int>(q.cols()));
    core.left_unfolding() = q;
    train.cores[k + 1] = std::move(next);
  }
}

/// Right singular vectors of a matrix, and its singular values: QR leaves only a square to them.
ThinSvd right_singular(const Eigen::MatrixXd& matrix) {
  Eigen::MatrixXd square;
  if (matrix.rows() >= matrix.cols()) return thin_svd(qr_factor(matrix));
  const Eigen::MatrixXd rows = thin_qr(matrix.transpose(), square);
  ThinSvd svd = thin_svd(square.transpose());
  svd.v = rows * svd.v;
  return svd;
}

/// Number of leading singular values to keep so that the others' root sum of squares stays below `tolerance`.
int kept_rank(const Eigen::VectorXd& singular_values, double tolerance) {
  double tail = 0.0;
  Eigen::Index rank = singular_values.size();
  while (rank > 1) {
    tail += singular_values[rank - 1] * singular_values[rank - 1];
    if (std::sqrt(tail) > tolerance) break;
    --rank;
  }
  return static_cast<int>(rank);
}

}  // namespace

std::vector<int> TensorTrain::ranks() const {
  std::vector<int> r;
  for (std::size_t k = 0; k + 1 < cores.size(); ++k) r.push_back(cores[k].right);
  return r;
}

double TensorTrain::entry(std::span<const int> index) const {
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Ones(1);
  for (std::size_t k = 0; k < cores.size(); ++k) row = (row * cores[k].slice(index[k])).eval();
  return row[0];
}

TensorTrain to_train(const SeparatedTensor& tensor) {
  TensorTrain train;
  const Eigen::Index terms = std::max(tensor.rank(), 1);
  Eigen::MatrixXd carry = Eigen::MatrixXd::Zero(1, terms);
  if (tensor.rank() > 0) carry.row(0) = tensor.weights.transpose();
  for (int k = 0; k < tensor.modes(); ++k) {
    const Eigen::MatrixXd& factor = tensor.factors[static_cast<std::size_t>(k)];
    const bool last = k + 1 == tensor.modes();
    Eigen::MatrixXd unfolding = carried_unfolding(carry, factor);
    if (last) unfolding = Eigen::MatrixXd(unfolding.rowwise().sum());
    Eigen::MatrixXd next;
    const Eigen::MatrixXd q = last ? unfolding : thin_qr(unfolding, next);
    TrainCore core(static_cast<int>(carry.rows()), static_cast<int>(factor.rows()),
                   static_cast<int>(q.cols()));
    core.left_unfolding() = q;
    train.cores.push_back(std::move(core));
    carry = std::move(next);
  }
  return train;
}

TensorTrain to_train(const Eigen::MatrixXd& values, const std::vector<int>& sizes, double tolerance) {
  const double expected = std::accumulate(sizes.begin(), sizes.end(), 1.0, std::multiplies<>());
  if (sizes.empty() || values.rows() < 1 || static_cast<double>(values.cols()) != expected) {
    throw ArgumentError(fmt::format("{} x {} values for modes of {} entries", values.rows(), values.cols(),
                                    fmt::join(sizes, " x ")));
  }
  const double per_cut = tolerance / std::sqrt(static_cast<double>(sizes.size()));
  TensorTrain train;
  train.cores.resize(sizes.size() + 1);
  Eigen::MatrixXd carry = values;  // what is left of the first modes, times the rank
  int right = 1;
  for (std::size_t k = sizes.size(); k > 0; --k) {
    const Eigen::Index columns = Eigen::Index{sizes[k - 1]} * right;
    const Eigen::MatrixXd unfolding = carry.reshaped(carry.size() / columns, columns);
    const ThinSvd svd = right_singular(unfolding);
    const int rank = kept_rank(svd.singular, per_cut);
    TrainCore core(rank, sizes[k - 1], right);
    core.right_unfolding() = svd.v.leftCols(rank).transpose();
    train.cores[k] = std::move(core);
    carry = unfolding * svd.v.leftCols(rank);
    right = rank;
  }
  train.cores[0] = TrainCore(1, static_cast<int>(values.rows()), right);
  train.cores[0].left_unfolding() = carry;
  return train;
}

TensorTrain rounded(TensorTrain train, double tolerance) {
  orthogonalise_left(train);
  return cut_ranks(std::move(train), tolerance);
}

TensorTrain cut_ranks(TensorTrain train, double tolerance) {
  const double per_cut = tolerance / std::sqrt(std::max(1.0, static_cast<double>(train.modes() - 1)));
  for (std::size_t k = train.cores.size(); k-- > 1;) {
    TrainCore& core = train.cores[k];
    // Unfoldings are mostly wide: of that, only a square is left to the singular values.
    Eigen::MatrixXd square;
    const Eigen::MatrixXd rows = thin_qr(core.right_unfolding().transpose(), square);
    const ThinSvd svd = thin_svd(square.transpose());
    const int rank = kept_rank(svd.singular, per_cut);
    TrainCore cut(rank, core.size, core.right);
    cut.right_unfolding() = (rows * svd.v.leftCols(rank)).transpose();
    const Eigen::MatrixXd carry = svd.u.leftCols(rank) * svd.singular.head(rank).asDiagonal();
    TrainCore& before = train.cores[k - 1];
    TrainCore next(before.left, before.size, rank);
    next.left_unfolding() = before.left_unfolding() * carry;
    core = std::move(cut);
    before = std::move(next);
  }
  return train;
}

double norm(const TensorTrain& train) {
  TensorTrain copy = train;
  orthogonalise_left(copy);
  return copy.cores.back().data.norm();
}

double norm(const SeparatedTensor& tensor) {
  if (tensor.rank() == 0) return 0.0;
  // Inner products are cheaper, and as good while terms do not cancel: their error is round-off of the terms'
  // sizes.
  Eigen::ArrayXd sizes = tensor.weights.cwiseAbs();
  for (const Eigen::MatrixXd& factor : tensor.factors) sizes *= factor.colwise().norm().transpose().array();
  const double fast = fast_norm(tensor);
  const double noise = std::numeric_limits<double>::epsilon() * sizes.sum() * sizes.sum();
  if (noise < 1e-8 * fast * fast) return fast;
  // As to_train(), of whose cores only the last one matters.
  Eigen::MatrixXd carry = tensor.weights.transpose();
  for (int k = 0; k + 1 < tensor.modes(); ++k) {
    carry = qr_factor(carried_unfolding(carry, tensor.factors[static_cast<std::size_t>(k)]));
  }
  return (carry * tensor.factors.back().transpose()).norm();
}

SeparatedTensor to_separated(const TensorTrain& train, double tolerance) {
  SeparatedTensor result;
  std::vector<int> ranks = train.ranks();
  double products = 1.0;
  for (const int r : ranks) products *= r;
  if (products > kMaxChains) {
    throw ArgumentError(
        fmt::format("a train of ranks {} has {:.3g} products, expected at most {}; see separate()",
                    fmt::join(ranks, ", "), products, kMaxChains));
  }
  const auto chains = static_cast<Eigen::Index>(products);
  result.weights = Eigen::VectorXd::Ones(chains);
  ranks.push_back(1);
  Eigen::Index stride = 1;  // of the rank on the left of the mode
  for (std::size_t k = 0; k < train.cores.size(); ++k) {
    const TrainCore& core = train.cores[k];
    Eigen::MatrixXd factor(core.size, chains);
    const Eigen::Index right_stride = k == 0 ? 1 : stride * core.left;
    for (Eigen::Index c = 0; c < chains; ++c) {
      const Eigen::Index l = k == 0 ? 0 : (c / stride) % core.left;
      const Eigen::Index r = (c / right_stride) % core.right;
      for (int i = 0; i < core.size; ++i) factor(i, c) = core.data[l + core.left * (i + core.size * r)];
    }
    result.factors.push_back(std::move(factor));
    stride = right_stride;
  }
  result.normalise();
  std::vector<int> order(static_cast<std::size_t>(result.rank()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return result.weights[a] > result.weights[b]; });
  double dropped = 0.0;
  while (!order.empty()) {
    dropped += result.weights[order.back()];
    if (dropped > tolerance) break;
    order.pop_back();
  }
  result.keep(order);
  return result;
}

}  // namespace samara::pgd
