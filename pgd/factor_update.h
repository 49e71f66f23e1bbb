#pragma once

#include "samara/pgd/linear_problem.h"

namespace samara::pgd {

/// Projects all weights together: B alpha = H, (6.15) of the dissertation. The factors stay.
/// @returns false if B is singular; u is then unchanged.
bool project_weights(const ProjectedForm& form, SeparatedTensor& u);

/// Updates the whole factor matrix of one mode after the other, the other modes' factors kept (block
/// alternating least squares for the minimal residual), `sweeps` times over all modes. u comes back
/// normalised.
/// @returns false if a system was singular; u then holds the updates made before.
bool update_factors(const ProjectedForm& form, SeparatedTensor& u, int sweeps);

}  // namespace samara::pgd
