#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/base/shared_progress.h"
#include "samara/models/added_mass/panel_integrals.h"
#include "samara/models/bodies/triangle_mesh.h"

namespace samara::models::added_mass {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using SixColumns = Eigen::Matrix<double, Eigen::Dynamic, 6>;

/// The equations of panel_solver.h for the potentials of the six unit motions at the corners,
/// matrix * phi = rhs, and the measure of their energy, K = -fluid_density phi^T flux.
struct PanelSystem {
  RowMajorMatrix matrix;
  SixColumns rhs;
  SixColumns flux;  ///< Int psi_a v_j dS
};

/// @param mesh closed, of a size of order 1, about the origin
/// @returns a system to be thrown away if the progress callback asked to cancel
PanelSystem assemble(const TriangleMesh& mesh, SharedProgress& progress);

/// Steps of its progress.
double assembly_pieces(const TriangleMesh& mesh);

}  // namespace samara::models::added_mass
