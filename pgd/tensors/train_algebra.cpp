#include "samara/pgd/tensors/train_algebra.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "samara/base/errors.h"
#include "samara/pgd/tensors/grid_check.h"
#include "samara/pgd/tensors/thin_qr.h"

namespace samara::pgd {

namespace {

std::vector<int> sizes_of(const TensorTrain& train) {
  std::vector<int> sizes;
  for (const TrainCore& core : train.cores) sizes.push_back(core.size);
  return sizes;
}

/// a's slice beside, above or, in the middle of the train, diagonal to b's.
TrainCore sum_core(const TrainCore& a, const TrainCore& b, bool first, bool last) {
  TrainCore core(first ? 1 : a.left + b.left, a.size, last ? 1 : a.right + b.right);
  const int row = first ? 0 : a.left;
  const int column = last ? 0 : a.right;
  for (int i = 0; i < a.size; ++i) {
    Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> slice(
        core.data.data() + Eigen::Index{core.left} * i, core.left, core.right,
        Eigen::OuterStride<>(Eigen::Index{core.left} * core.size));
    slice.topLeftCorner(a.left, a.right) += a.slice(i);
    slice.block(row, column, b.left, b.right) += b.slice(i);
  }
  return core;
}

/// carry (s x r r', column p + r q for ranks p of a and q of b) times the Kronecker product of the cores:
/// unfolding (s n) x (r r' of the next rank).
Eigen::MatrixXd carried_product(const Eigen::MatrixXd& carry, const TrainCore& a, const TrainCore& b) {
  const Eigen::Index s = carry.rows();
  TrainCore result(static_cast<int>(s), a.size, a.right * b.right);
  const Eigen::Map<const Eigen::MatrixXd> columns(carry.data(), s * a.left, b.left);
  for (int i = 0; i < a.size; ++i) {
    const Eigen::MatrixXd half = columns * b.slice(i);  // (s r) x r'
    for (int q = 0; q < b.right; ++q) {
      const Eigen::Map<const Eigen::MatrixXd> block(half.col(q).data(), s, a.left);
      const Eigen::MatrixXd full = block * a.slice(i);
      for (int p = 0; p < a.right; ++p) {
        result.data.segment(s * (i + Eigen::Index{a.size} * (p + Eigen::Index{a.right} * q)), s) =
            full.col(p);
      }
    }
  }
  return result.left_unfolding();
}

TrainCore core_from_unfolding(const Eigen::MatrixXd& unfolding, Eigen::Index left, int size) {
  TrainCore core(static_cast<int>(left), size, static_cast<int>(unfolding.cols()));
  core.left_unfolding() = unfolding;
  return core;
}

/// The train without a mode whose core was reduced to one matrix (left rank x right rank).
TensorTrain without_mode(const TensorTrain& a, int mode, const Eigen::MatrixXd& matrix) {
  if (a.modes() == 1) throw ArgumentError("the only mode of a train cannot go: use entry() or inner()");
  TensorTrain result;
  const auto removed = static_cast<std::size_t>(mode);
  for (std::size_t k = 0; k < a.cores.size(); ++k) {
    if (k != removed) result.cores.push_back(a.cores[k]);
  }
  if (removed + 1 < a.cores.size()) {
    const TrainCore& next = a.cores[removed + 1];
    TrainCore core(static_cast<int>(matrix.rows()), next.size, next.right);
    core.right_unfolding() = matrix * next.right_unfolding();
    result.cores[removed] = std::move(core);
  } else {
    const TrainCore& before = a.cores[removed - 1];
    result.cores.back() = core_from_unfolding(before.left_unfolding() * matrix, before.left, before.size);
  }
  return result;
}

template <class Matrix>
TensorTrain apply_matrix(TensorTrain a, int mode, const Matrix& matrix) {
  require_mode(mode, a.modes());
  TrainCore& core = a.cores[static_cast<std::size_t>(mode)];
  require_length("a matrix", matrix.cols(), mode, core.size);
  TrainCore result(core.left, static_cast<int>(matrix.rows()), core.right);
  const Matrix transposed = matrix.transpose();
  // For one right rank the entries are a left x size matrix.
  for (int r = 0; r < core.right; ++r) {
    const Eigen::Index block = Eigen::Index{core.left} * core.size;
    const Eigen::Map<const Eigen::MatrixXd> values(core.data.data() + block * r, core.left, core.size);
    Eigen::Map<Eigen::MatrixXd>(result.data.data() + Eigen::Index{result.left} * result.size * r, result.left,
                                result.size) = values * transposed;
  }
  core = std::move(result);
  return a;
}

}  // namespace

double full_size(const TensorTrain& a) {
  double entries = 1.0;
  for (const TrainCore& core : a.cores) entries *= core.size;
  return entries;
}

TensorTrain scaled(TensorTrain a, double factor) {
  a.cores.back().data *= factor;
  return a;
}

TensorTrain sum(const TensorTrain& a, const TensorTrain& b, double scale_b) {
  require_same_sizes("sum", sizes_of(a), sizes_of(b));
  TensorTrain result;
  for (std::size_t k = 0; k < a.cores.size(); ++k) {
    const bool last = k + 1 == a.cores.size();
    TrainCore other = b.cores[k];
    if (last) other.data *= scale_b;
    result.cores.push_back(sum_core(a.cores[k], other, k == 0, last));
  }
  return result;
}

double inner(const TensorTrain& a, const TensorTrain& b) {
  require_same_sizes("inner product", sizes_of(a), sizes_of(b));
  Eigen::MatrixXd products = Eigen::MatrixXd::Ones(1, 1);  // rank of a x rank of b
  for (std::size_t k = 0; k < a.cores.size(); ++k) {
    TrainCore carried(static_cast<int>(products.rows()), b.cores[k].size, b.cores[k].right);
    carried.right_unfolding() = products * b.cores[k].right_unfolding();
    products = a.cores[k].left_unfolding().transpose() * carried.left_unfolding();
  }
  return products(0, 0);
}

double distance(const TensorTrain& a, const TensorTrain& b) {
  return norm(sum(a, b, -1.0));
}

TensorTrain hadamard(const TensorTrain& a, const TensorTrain& b) {
  require_same_sizes("product", sizes_of(a), sizes_of(b));
  TensorTrain result;
  for (std::size_t k = 0; k < a.cores.size(); ++k) {
    const int left = a.cores[k].left * b.cores[k].left;
    const Eigen::MatrixXd unfolding =
        carried_product(Eigen::MatrixXd::Identity(left, left), a.cores[k], b.cores[k]);
    result.cores.push_back(core_from_unfolding(unfolding, left, a.cores[k].size));
  }
  return result;
}

TensorTrain rounded_hadamard(const TensorTrain& a, const TensorTrain& b, double tolerance) {
  require_same_sizes("product", sizes_of(a), sizes_of(b));
  if (a.modes() == 1) return rounded(hadamard(a, b), tolerance);
  // The last core has more rows than the mode has nodes: only as many as those are kept for the core before.
  const TrainCore& last_a = a.cores.back();
  const TrainCore& last_b = b.cores.back();
  Eigen::MatrixXd last(last_a.size, Eigen::Index{last_a.left} * last_b.left);
  for (int i = 0; i < last_a.size; ++i)
    last.row(i) = (last_a.slice(i) * last_b.slice(i).transpose()).reshaped().transpose();
  Eigen::MatrixXd rest;
  last = thin_qr(last, rest);
  TensorTrain result;
  Eigen::MatrixXd carry = Eigen::MatrixXd::Ones(1, 1);
  for (std::size_t k = 0; k + 1 < a.cores.size(); ++k) {
    const Eigen::Index left = carry.rows();
    Eigen::MatrixXd unfolding = carried_product(carry, a.cores[k], b.cores[k]);
    if (k + 2 == a.cores.size()) unfolding = (unfolding * rest.transpose()).eval();
    result.cores.push_back(core_from_unfolding(thin_qr(unfolding, carry), left, a.cores[k].size));
  }
  TrainCore core(static_cast<int>(carry.rows()), last_a.size, 1);
  core.right_unfolding() = carry * last.transpose();
  result.cores.push_back(std::move(core));
  return cut_ranks(std::move(result), tolerance);
}

TensorTrain contracted(const TensorTrain& a, int mode, const Eigen::VectorXd& weights) {
  require_mode(mode, a.modes());
  const TrainCore& core = a.cores[static_cast<std::size_t>(mode)];
  require_length("a contraction", weights.size(), mode, core.size);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(core.left, core.right);
  for (int i = 0; i < core.size; ++i) matrix += weights[i] * core.slice(i);
  return without_mode(a, mode, matrix);
}

TensorTrain restricted(const TensorTrain& a, int mode, int index) {
  require_mode(mode, a.modes());
  const TrainCore& core = a.cores[static_cast<std::size_t>(mode)];
  require_index(index, mode, core.size);
  return without_mode(a, mode, core.slice(index));
}

TensorTrain applied(TensorTrain a, int mode, const SparseMatrix& matrix) {
  return apply_matrix(std::move(a), mode, matrix);
}

TensorTrain applied(TensorTrain a, int mode, const Eigen::MatrixXd& matrix) {
  return apply_matrix(std::move(a), mode, matrix);
}

}  // namespace samara::pgd
