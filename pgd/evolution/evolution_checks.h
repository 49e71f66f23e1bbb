#pragma once

#include <cstddef>
#include <vector>

#include "samara/pgd/evolution/evolution_problem.h"

namespace samara::pgd {

/// What every evolution problem must hold of its system, states and initial values.
/// @throws ArgumentError naming the first that does not
void check_states(const EvolutionSystem* system, const std::vector<OutputLabel>& states,
                  const std::vector<double>& scales, const std::vector<InitialValue>& initial,
                  std::size_t parameters);

}  // namespace samara::pgd
