#include "samara/pgd/linear/row_measure.h"

#include <Eigen/Cholesky>

namespace samara::pgd {

RowMeasure::RowMeasure(const LinearProblem& problem, std::size_t mode) {
  if (mode < problem.row_norms.size() && problem.row_norms[mode].size() > 0) {
    root_ = Eigen::MatrixXd(problem.row_norms[mode]).llt().matrixL();
  } else if (mode < problem.row_weights.size()) {
    weights_ = problem.row_weights[mode];
  }
}

// Of no columns (a right-hand side without terms) Eigen's triangular solvers would read the first number.
Eigen::MatrixXd RowMeasure::apply(const Eigen::MatrixXd& x) const {
  if (x.size() == 0) return x;
  if (root_.size() > 0) return root_.triangularView<Eigen::Lower>().solve(x);
  if (weights_.size() > 0) return weights_.cwiseSqrt().asDiagonal() * x;
  return x;
}

Eigen::MatrixXd RowMeasure::squared(const Eigen::MatrixXd& x) const {
  if (x.size() == 0) return x;
  if (root_.size() > 0) return root_.transpose().triangularView<Eigen::Upper>().solve(apply(x));
  if (weights_.size() > 0) return weights_.asDiagonal() * x;
  return x;
}

ModeOperator RowMeasure::between(const ModeOperator& left, const ModeOperator& right) const {
  if (root_.size() == 0) return left.transposed_times(weights_, right);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(root_.rows(), root_.rows());
  return ModeOperator::dense(apply(left.apply(identity)).transpose() * apply(right.apply(identity)));
}

std::vector<RowMeasure> row_measures(const LinearProblem& problem) {
  std::vector<RowMeasure> measures;
  for (std::size_t k = 0; k < problem.rhs.factors.size(); ++k) measures.emplace_back(problem, k);
  return measures;
}

}  // namespace samara::pgd
