#pragma once

#include <vector>

#include "samara/pgd/separated_operator.h"
#include "samara/pgd/separated_tensor.h"

namespace samara::pgd {

/// Find U with D(U) = G on a grid, all three in separated form.
struct LinearProblem {
  SeparatedOperator op;
  SeparatedTensor rhs;
  /// Quadrature weights of the equations per mode, so that sums over nodes are integrals; a mode without
  /// entry (or an empty list) counts every equation once. Both projections and the residual norm use them.
  std::vector<Eigen::VectorXd> row_weights = {};

  /// @throws ArgumentError if the operator is empty, sizes do not match, an entry is not finite or a weight
  /// is not
  ///   positive.
  void validate() const;
};

/// How the unknown factors are determined from the equations.
enum class Projection {
  /// <D U - G, V> = 0 for variations V of U: right for symmetric positive operators, may stagnate for others.
  galerkin,
  /// min ||D U - G||: any operator; the residual never increases.
  minimal_residual,
};

/// The equations after projection: <V, A U> = <V, b> for all variations V.
struct ProjectedForm {
  SeparatedOperator a;
  SeparatedTensor b;
};

/// Galerkin: A = W D, b = W G. Minimal residual: A = D^T W D (rank squared), b = D^T W G.
ProjectedForm project(const LinearProblem& problem, Projection projection);

/// ||D U - G|| / ||G|| in the weighted norm, through inner products: cheap, resolves down to about 1e-8.
double fast_relative_residual(const LinearProblem& problem, const SeparatedTensor& u);

/// The same without cancellation, by orthogonalisation. O(d n R^3) with R = terms of G and of D times those
/// of U.
double relative_residual(const LinearProblem& problem, const SeparatedTensor& u);

}  // namespace samara::pgd
