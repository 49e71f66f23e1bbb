#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

/// The staggered grid of F. Harlow and J. Welch, Phys. Fluids 8 (1965) 2182: pressure and all scalars in the centres
/// of cubic cells, each component of the velocity on the faces that it crosses. One code serves the plane and space:
/// a plane grid has one layer of cells along z, and every loop over directions ends at `dimensions`.
namespace samara::flow {

using Index = std::ptrdiff_t;

/// One number per cell, or per face of one direction, with two cells of margin beyond every border. Rows along x are
/// contiguous. On faces of direction d, entry c is the lower face of cell c; the last face of a row lies in the margin.
using Field = std::vector<double>;

/// Components of the velocity, each on the faces of its direction. That of z is empty in the plane.
using FaceField = std::array<Field, 3>;

struct MacGrid {
  /// Cells beyond the border that fields hold: what van Leer's slopes reach.
  static constexpr int kMargin = 2;

  int dimensions = 2;
  std::array<int, 3> cells = {1, 1, 1};
  double spacing = 1.0;                              ///< h, edge of a cell [length of the case]
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< lower corner of the domain; z of the plane is 0
  std::array<Index, 3> stride = {1, 0, 0};           ///< from a cell to the next along x, y, z
  Index first = 0;                                   ///< place of cell (0, 0, 0)
  Index size = 0;                                    ///< entries of a field, margins included

  /// @throws ArgumentError if dimensions is not 2 or 3, a number of cells is below 1, or the spacing not positive.
  MacGrid(int dimensions, const std::array<int, 3>& cells, double spacing, const Eigen::Vector3d& origin);

  Index at(int i, int j, int k = 0) const { return first + i * stride[0] + j * stride[1] + k * stride[2]; }
  Index cell_count() const { return Index{cells[0]} * cells[1] * cells[2]; }
  /// Extent of the domain along a direction.
  double length(int direction) const { return spacing * cells[static_cast<std::size_t>(direction)]; }
  Eigen::Vector3d centre(int i, int j, int k = 0) const;
  /// Centre of the lower face of a cell.
  Eigen::Vector3d face_centre(int direction, int i, int j, int k = 0) const;
  /// Centre of a cell by its index, or of its lower face of a direction (-1: of the cell).
  Eigen::Vector3d place(Index c, int face_direction) const;
  Field field(double value = 0.0) const { return Field(static_cast<std::size_t>(size), value); }
  FaceField faces(double value = 0.0) const;
};

/// A range of cells or faces, `end` excluded.
struct Range {
  std::array<int, 3> begin = {0, 0, 0};
  std::array<int, 3> end = {1, 1, 1};

  int width() const { return end[0] - begin[0]; }
  int rows() const { return (end[1] - begin[1]) * (end[2] - begin[2]); }
};

inline Range all_cells(const MacGrid& grid) {
  return {{0, 0, 0}, grid.cells};
}

}  // namespace samara::flow
