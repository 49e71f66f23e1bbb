#include "samara/pgd/tensors/tensor_algebra.h"

#include <utility>

#include "samara/pgd/tensors/grid_check.h"

namespace samara::pgd {

namespace {

/// The tensor without a mode whose factors were reduced to one number per term.
SeparatedTensor without_mode(SeparatedTensor a, int mode, const Eigen::VectorXd& values) {
  a.weights.array() *= values.array();
  a.factors.erase(a.factors.begin() + mode);
  return a;
}

template <class Matrix>
SeparatedTensor apply_matrix(SeparatedTensor a, int mode, const Matrix& matrix) {
  require_mode(mode, a.modes());
  require_length("a matrix", matrix.cols(), mode, a.size(mode));
  Eigen::MatrixXd& factor = a.factors[static_cast<std::size_t>(mode)];
  factor = Eigen::MatrixXd(matrix * factor);
  return a;
}

}  // namespace

SeparatedTensor scaled(SeparatedTensor a, double factor) {
  a.weights *= factor;
  return a;
}

SeparatedTensor sum(SeparatedTensor a, const SeparatedTensor& b, double scale_b) {
  require_same_sizes("sum", a.sizes(), b.sizes());
  a.append(b, scale_b);
  return a;
}

SeparatedTensor hadamard(const SeparatedTensor& a, const SeparatedTensor& b) {
  require_same_sizes("product", a.sizes(), b.sizes());
  // Term r of a times all terms of b is a block of columns.
  const Eigen::Index block = b.weights.size();
  SeparatedTensor result;
  result.weights.resize(a.weights.size() * block);
  for (Eigen::Index r = 0; r < a.weights.size(); ++r) {
    result.weights.segment(r * block, block) = a.weights[r] * b.weights;
  }
  for (std::size_t k = 0; k < a.factors.size(); ++k) {
    Eigen::MatrixXd factor(a.factors[k].rows(), a.weights.size() * block);
    for (Eigen::Index r = 0; r < a.weights.size(); ++r) {
      factor.middleCols(r * block, block) = a.factors[k].col(r).asDiagonal() * b.factors[k];
    }
    result.factors.push_back(std::move(factor));
  }
  return result;
}

SeparatedTensor contracted(SeparatedTensor a, int mode, const Eigen::VectorXd& weights) {
  require_mode(mode, a.modes());
  require_length("a contraction", weights.size(), mode, a.size(mode));
  const Eigen::VectorXd values = a.factors[static_cast<std::size_t>(mode)].transpose() * weights;
  return without_mode(std::move(a), mode, values);
}

SeparatedTensor restricted(SeparatedTensor a, int mode, int index) {
  require_mode(mode, a.modes());
  require_index(index, mode, a.size(mode));
  const Eigen::VectorXd values = a.factors[static_cast<std::size_t>(mode)].row(index).transpose();
  return without_mode(std::move(a), mode, values);
}

SeparatedTensor applied(SeparatedTensor a, int mode, const SparseMatrix& matrix) {
  return apply_matrix(std::move(a), mode, matrix);
}

SeparatedTensor applied(SeparatedTensor a, int mode, const Eigen::MatrixXd& matrix) {
  return apply_matrix(std::move(a), mode, matrix);
}

}  // namespace samara::pgd
