#pragma once

#include "samara/pgd/linear_problem.h"
#include "samara/pgd/operator_chain.h"

namespace samara::pgd {

/// The equations after projection: <V, A U> = <V, b> for all variations V.
struct ProjectedForm {
  OperatorChain a;
  SeparatedTensor b;
};

/// Galerkin: A = W D, b = W G. Minimal residual: A = D^T W D (terms squared), b = D^T W G. Products of parts
/// are formed once for every pair of distinct parts.
ProjectedForm project(const LinearProblem& problem, Projection projection);

}  // namespace samara::pgd
