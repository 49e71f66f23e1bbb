#pragma once

#include "samara/models/added_mass/panel_system.h"

namespace samara::models::added_mass {

struct GmresOutcome {
  bool converged = false;
  int iterations = 0;
};

/// Solves A x_c = b_c for the six columns at once, so that each passage through A serves all, by GMRES
/// without restart (Y. Saad, M. H. Schultz, SIAM J. Sci. Stat. Comput. 7 (1986) 856-869) on A scaled from
/// both sides by the roots of its diagonal, until each scaled residual is below tolerance times the scaled
/// b_c, or until the progress callback asks to cancel.
GmresOutcome gmres(const RowMajorMatrix& A, const SixColumns& b, double tolerance, int max_iterations,
                   SharedProgress& progress, SixColumns& x);

}  // namespace samara::models::added_mass
