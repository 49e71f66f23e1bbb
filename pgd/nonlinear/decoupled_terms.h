#pragma once

#include "samara/pgd/evolution/evolution_terms.h"
#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/linear/separated_operator.h"
#include "samara/pgd/tensors/separated_tensor.h"

/// What the equation of one unknown is made of, see decoupling.h.
namespace samara::pgd {

/// Linear in its own unknown, with parameters as its only other factors.
bool is_own_linear(const Monomial& term);

/// x0 of one unknown over its scale; its time mode has one node.
SeparatedTensor initial_tensor(const EvolutionProblem& problem, std::size_t state);

/// I - S a of one unknown, a the sum of its own linear terms. The system must be a polynomial.
SeparatedOperator own_operator(const EvolutionGrid& grid, int state);

}  // namespace samara::pgd
