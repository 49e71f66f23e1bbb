#pragma once

#include <vector>

#include "samara/pgd/linear/separated_operator.h"
#include "samara/pgd/tensors/separated_tensor.h"

namespace samara::pgd {

/// Find U with D(U) = G on a grid, all three in separated form.
struct LinearProblem {
  SeparatedOperator op;
  SeparatedTensor rhs;
  /// Quadrature weights of the equations per mode, so that sums over nodes are integrals; a mode without
  /// entry (or an empty list) counts every equation once. Both projections and the residual norm use them.
  std::vector<Eigen::VectorXd> row_weights = {};
  /// Symmetric positive matrices N per mode: the residual r of the equations is measured as r^T N^-1 r, the
  /// dual norm of N, instead of by weights; a mode without entry, or an empty matrix, has none. Weak forms of
  /// diffusion are measured well by their own stiffness: Euclid's norm sees little but the shortest waves.
  /// Galerkin projections do not depend on it. Sizes of up to some thousand: N^-1 fills the operator.
  std::vector<SparseMatrix> row_norms = {};

  /// @throws ArgumentError if the operator is empty, sizes do not match, an entry is not finite or a weight
  /// is not
  ///   positive.
  void validate() const;
};

/// How the unknown factors are determined from the equations.
enum class Projection {
  /// <D U - G, V> = 0 for variations V of U: right for symmetric positive operators, may stagnate for others.
  galerkin,
  /// min ||D U - G||: any operator; the residual never increases (a term whose normal equations are too badly
  /// conditioned to lower it is dropped).
  minimal_residual,
};

}  // namespace samara::pgd
