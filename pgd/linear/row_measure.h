#pragma once

#include <vector>

#include "samara/pgd/linear/linear_problem.h"

namespace samara::pgd {

/// How the equations of one mode are measured: r^T S^T S r, where S is the root of the weights or, for a norm
/// N = L L^T, the inverse of L.
class RowMeasure {
 public:
  RowMeasure(const LinearProblem& problem, std::size_t mode);

  /// S x, columns at once.
  Eigen::MatrixXd apply(const Eigen::MatrixXd& x) const;
  /// left^T S^T S right.
  ModeOperator between(const ModeOperator& left, const ModeOperator& right) const;
  /// S^T S x.
  Eigen::MatrixXd squared(const Eigen::MatrixXd& x) const;

 private:
  Eigen::VectorXd weights_;  ///< empty: ones
  Eigen::MatrixXd root_;     ///< L; empty without a norm
};

/// One for every mode.
std::vector<RowMeasure> row_measures(const LinearProblem& problem);

}  // namespace samara::pgd
