#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/tensors/separated_tensor.h"

namespace samara::pgd {

/// The part of an operator's term that acts on one mode: identity, diagonal, sparse or dense.
class ModeOperator {
 public:
  /// Which storage suffices. The order matters: a sum needs the larger of the two.
  enum class Structure { diagonal, sparse, dense };

  static ModeOperator identity(int size) { return ModeOperator(size); }
  static ModeOperator diagonal(Eigen::VectorXd values) { return ModeOperator(std::move(values)); }
  static ModeOperator sparse(SparseMatrix matrix) {
    matrix.makeCompressed();
    return ModeOperator(std::move(matrix));
  }
  static ModeOperator dense(Eigen::MatrixXd matrix) { return ModeOperator(std::move(matrix)); }

  int rows() const;
  int cols() const;
  Structure structure() const;

  /// y = this * x for a matrix x of columns.
  Eigen::MatrixXd apply(const Eigen::MatrixXd& x) const;
  /// y = this * x without allocation.
  void apply_to(Eigen::Ref<const Eigen::VectorXd> x, Eigen::Ref<Eigen::VectorXd> y) const;

  /// target += scale * this; the target's structure must be at least this one's.
  void add_to_diagonal(Eigen::Ref<Eigen::VectorXd> target, double scale) const;
  void add_to_dense(Eigen::Ref<Eigen::MatrixXd> target, double scale) const;
  void add_to_triplets(std::vector<Eigen::Triplet<double>>& target, int row, int col, double scale) const;

  /// |this| |x|, entry by entry: what rounding in apply(x) is relative to.
  Eigen::MatrixXd apply_magnitudes(const Eigen::MatrixXd& x) const;
  /// Largest |entry|.
  double largest() const;
  bool all_finite() const;
  /// Same storage, same numbers. O(entries).
  bool operator==(const ModeOperator& other) const;
  /// Equal for equal operators, and as good as never for others.
  std::size_t fingerprint() const;

  /// this^T diag(weights) other; empty weights mean ones.
  ModeOperator transposed_times(const Eigen::VectorXd& weights, const ModeOperator& other) const;
  /// diag(weights) this; empty weights mean ones.
  ModeOperator row_scaled(const Eigen::VectorXd& weights) const;

 private:
  using Storage = std::variant<int, Eigen::VectorXd, SparseMatrix, Eigen::MatrixXd>;
  explicit ModeOperator(Storage storage) : storage_(std::move(storage)) {}
  SparseMatrix as_sparse() const;
  Eigen::MatrixXd as_dense() const;

  Storage storage_;  ///< int: the identity of that size
};

/// D = sum_i D_1^i (x) .. (x) D_d^i, (6.10) of the dissertation. All parts of a mode have one shape.
struct SeparatedOperator {
  std::vector<std::vector<ModeOperator>> terms;  ///< terms[i][mode]

  int rank() const { return static_cast<int>(terms.size()); }
  int modes() const { return terms.empty() ? 0 : static_cast<int>(terms.front().size()); }
  int size(int mode) const { return terms.front()[static_cast<std::size_t>(mode)].cols(); }

  /// D u: rank() * u.rank() terms.
  SeparatedTensor apply(const SeparatedTensor& u) const;
};

}  // namespace samara::pgd
