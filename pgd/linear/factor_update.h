#pragma once

#include <vector>

#include "samara/pgd/linear/mode_system.h"
#include "samara/pgd/linear/projection.h"
#include "samara/pgd/linear/sparse_solver.h"

namespace samara::pgd {

/// Projects all weights together: B alpha = H, (6.15) of the dissertation. The factors stay.
/// @returns false if B is singular; u is then unchanged.
bool project_weights(const ProjectedForm& form, SeparatedTensor& u);

struct FactorUpdateOptions {
  int sweeps = 1;
  /// Ends the sweeps once one changes the weights by less than this, relative to the largest; 0: never.
  double tolerance = 0.0;
  SparseSolverKind solver = SparseSolverKind::automatic;  ///< where the terms of a mode do not decouple
};

/// Updates the whole factor matrix of one mode after the other, the other modes' factors kept (block
/// alternating least squares for the minimal residual), sweep by sweep over all modes. u comes back
/// normalised. O(links R^2 + n R^2 parts) per mode and the system of factor_system.h.
/// @returns false if a system was singular; u then holds the updates made before.
bool update_factors(const ProjectedForm& form, std::vector<ModeSystem>& systems, SeparatedTensor& u,
                    const FactorUpdateOptions& options);

}  // namespace samara::pgd
