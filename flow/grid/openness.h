#pragma once

#include <array>
#include <optional>
#include <vector>

#include "samara/flow/grid/borders.h"
#include "samara/flow/grid/mac_grid.h"
#include "samara/flow/grid/shape.h"

/// A body on the grid: how much of every face and cell is open to the fluid. Y. Ng, C. Min, F. Gibou, J. Comput. Phys.
/// 228 (2009) 8807; C. Batty, F. Bertails, R. Bridson, ACM Trans. Graphics 26 (2007) 100.
///
/// The control volume of a velocity u_d on face f reaches from the centre of the cell below to that above. Its own
/// faces across direction j are open by the mean of a_j over those two cells: then the mass that leaves a control
/// volume is the mean of what leaves two cells, 0, and a uniform velocity stays uniform. The open volume is that of
/// the two half cells, but at least half its largest open face, so that slivers do not shorten the time step; as one
/// volume stands everywhere, momentum is conserved to rounding all the same.
namespace samara::flow {

/// A piece of a body's surface in a control volume.
struct WallPiece {
  Index at = 0;           ///< face or cell
  double area = 0.0;      ///< of the surface, in h^(dimensions - 1)
  double distance = 0.0;  ///< mean distance of the open part from the surface [length]
  bool border = false;    ///< of a wall of the domain, not of the body
};

struct Openness {
  explicit Openness(const MacGrid& grid);

  FaceField face;            ///< a in [0, 1]; 0: closed, and the velocity there is that of the body
  Field cell;                ///< c in [0, 1], open volume
  FaceField inverse_volume;  ///< 1/V of the faces' control volumes in h^-dimensions; 0 at closed faces
  /// Of the lower face across direction j of the control volume of u_d, at [d][j]: its open area by h over the
  /// distance that the velocities on both sides are apart. A velocity beside the body is the mean over the
  /// open part of its volume, nearer to its neighbour than h; with h between them the body would act as if it
  /// were a quarter of a cell thinner all round. The distance is that over which a profile that is linear from
  /// the surface on has their difference.
  std::array<FaceField, 3> conduction;
  Field inverse_cell;                                ///< 1/volume of cells for transport; 0 at closed ones
  std::array<std::vector<WallPiece>, 3> wall_faces;  ///< open faces beside the body or a wall with a law
  std::vector<WallPiece> wall_cells;                 ///< open cells beside them
  std::array<std::vector<Index>, 3> closed_faces;    ///< within the body
  std::vector<Index> closed_cells;
  Range near = {{0, 0, 0}, {0, 0, 0}};  ///< all cells and faces that the body changes
};

/// Faces that are open by less count as closed.
inline constexpr double kClosed = 0.02;

/// @param body none: all is open
/// @param borders periodic ones continue the body
Openness measure_openness(const MacGrid& grid, const Borders& borders,
                          const std::optional<PlacedShape>& body);
/// The same in place, after the body has moved.
void measure_openness(const MacGrid& grid, const Borders& borders, const PlacedShape& body, Openness& open);

/// Moments of the open part of a cube of edge 1 that a plane cuts.
struct OpenPart {
  double volume = 0.0;
  double mean_distance = 0.0;  ///< from the plane
};

/// @param distance of the cube's centre from the plane, positive in the fluid; normal of the plane, into the fluid
OpenPart measure_open_part(double distance, const Eigen::Vector3d& normal, int dimensions);

/// The share of a square (or an edge, or a cube) that lies in the fluid, from the signed distances at its corners:
/// exact for a plane surface along its edges or diagonal, a clamped linear function between.
double open_share(const double* corner_distances, int corners);

}  // namespace samara::flow
