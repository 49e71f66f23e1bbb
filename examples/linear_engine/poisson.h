#pragma once

#include <vector>

#include "samara/pgd/linear/linear_problem.h"

/// -Laplace u = 1 on (0,1)^d, u = 0 on the border, by second-order differences on `nodes` inner nodes a side.
inline samara::pgd::LinearProblem poisson(int dimensions, int nodes) {
  using namespace samara::pgd;
  const double h = 1.0 / (nodes + 1);
  SparseMatrix second(nodes, nodes);
  for (int i = 0; i < nodes; ++i) {
    if (i > 0) second.insert(i, i - 1) = -1.0 / (h * h);
    second.insert(i, i) = 2.0 / (h * h);
    if (i + 1 < nodes) second.insert(i, i + 1) = -1.0 / (h * h);
  }
  const ModeOperator laplace = ModeOperator::sparse(second);
  const ModeOperator identity = ModeOperator::identity(nodes);

  // L (x) I (x) .. (x) I + I (x) L (x) .. + ..: one term for each dimension.
  LinearProblem problem;
  for (int i = 0; i < dimensions; ++i) {
    std::vector<ModeOperator> term(static_cast<std::size_t>(dimensions), identity);
    term[static_cast<std::size_t>(i)] = laplace;
    problem.op.terms.push_back(term);
  }
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(nodes);
  problem.rhs = SeparatedTensor::product(
      std::vector<Eigen::VectorXd>(static_cast<std::size_t>(dimensions), ones));
  return problem;
}
