#pragma once

#include "samara/pgd/linear/linear_problem.h"
#include "samara/pgd/linear/operator_chain.h"

namespace samara::pgd {

/// The equations after projection: <V, A U> = <V, b> for all variations V.
struct ProjectedForm {
  OperatorChain a;
  SeparatedTensor b;
};

/// Galerkin: A = W D, b = W G with the row weights W. Minimal residual: A = D^T S^T S D (terms squared),
/// b = D^T S^T S G with the row measure S. Products of parts are formed once for every pair of distinct
/// parts.
ProjectedForm project(const LinearProblem& problem, Projection projection);

}  // namespace samara::pgd
