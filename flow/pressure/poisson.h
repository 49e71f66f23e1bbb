#pragma once

#include <array>
#include <vector>

#include "samara/flow/grid/borders.h"
#include "samara/flow/grid/mac_grid.h"

/// The equation of the pressure on a staggered grid with a body:
///
///   sum over the faces of a cell of w_f (p_cell - p_neighbour) = b_cell
///
/// in units of the grid. The weights w are a^2/V: the open area twice, because it weighs the divergence and the
/// pressure's force, over the volume of the control volume. At an outflow p is 0 on the border itself, half a cell
/// away: the face counts twice. Borders where the velocity is given have no weight. The matrix is symmetric and
/// positive, semidefinite where no outflow fixes the level of the pressure.
namespace samara::flow {

struct PoissonMatrix {
  MacGrid grid;
  std::array<bool, 3> periodic = {};
  FaceField weight;        ///< of lower faces; those of the border are 0, or 2 w at an outflow
  Field inverse_diagonal;  ///< 0 of cells without open faces
  bool fixes_level = false;

  explicit PoissonMatrix(const MacGrid& on) : grid(on), weight(on.faces()), inverse_diagonal(on.field()) {}

  /// From the weights.
  void set_diagonal();
  /// Copies the values at periodic borders into the margins; the others meet no weight.
  void fill_margins(Field& x) const;
  /// b - A x of a row of cells, into r. Margins of x must be filled.
  void residual_row(Index row, const double* b, const double* x, double* r) const;
};

/// @param face, inverse_volume as in Openness
PoissonMatrix pressure_matrix(const MacGrid& grid, const Borders& borders, const FaceField& face,
                              const FaceField& inverse_volume);

/// The same in place, of a body that has moved.
void set_weights(const Borders& borders, const FaceField& face, const FaceField& inverse_volume,
                 PoissonMatrix& matrix);

/// The same on cells of twice the size: weights of the faces that become one are added, and halved in the direction in
/// which the distance doubles. Directions of one cell stay.
PoissonMatrix coarsened(const PoissonMatrix& fine);
/// Its weights, in place.
void coarsen(const PoissonMatrix& fine, PoissonMatrix& coarse);

}  // namespace samara::flow
