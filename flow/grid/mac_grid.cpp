#include "samara/flow/grid/mac_grid.h"

#include "samara/base/require.h"

namespace samara::flow {

MacGrid::MacGrid(int dimensions_, const std::array<int, 3>& cells_, double spacing_,
                 const Eigen::Vector3d& origin_)
    : dimensions(dimensions_), cells(cells_), spacing(spacing_), origin(origin_) {
  require(dimensions == 2 || dimensions == 3, "dimensions", dimensions, "2 or 3", "MacGrid");
  require_positive(spacing, "spacing", "MacGrid");
  if (dimensions == 2) {
    cells[2] = 1;
    origin.z() = 0.0;
  }
  Index step = 1;
  for (int d = 0; d < 3; ++d) {
    const auto at = static_cast<std::size_t>(d);
    require(cells[at] >= 1, "cells", cells[at], "at least 1", "MacGrid");
    const int margin = d < dimensions ? kMargin : 0;
    stride[at] = step;
    first += margin * step;
    step *= cells[at] + 2 * margin;
  }
  size = step;
}

Eigen::Vector3d MacGrid::centre(int i, int j, int k) const {
  Eigen::Vector3d place = origin + spacing * Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5);
  if (dimensions == 2) place.z() = 0.0;
  return place;
}

Eigen::Vector3d MacGrid::face_centre(int direction, int i, int j, int k) const {
  Eigen::Vector3d place = centre(i, j, k);
  place(direction) -= 0.5 * spacing;
  return place;
}

Eigen::Vector3d MacGrid::place(Index c, int face_direction) const {
  const int margin_z = dimensions == 3 ? kMargin : 0;
  const Index inside = c - first + kMargin * (stride[0] + stride[1]) + margin_z * stride[2];
  const int i = static_cast<int>(inside % stride[1]) - kMargin;
  const int j = static_cast<int>(inside % stride[2] / stride[1]) - kMargin;
  const int k = static_cast<int>(inside / stride[2]) - margin_z;
  return face_direction < 0 ? centre(i, j, k) : face_centre(face_direction, i, j, k);
}

FaceField MacGrid::faces(double value) const {
  FaceField faces;
  for (int d = 0; d < dimensions; ++d) faces[static_cast<std::size_t>(d)] = field(value);
  return faces;
}

}  // namespace samara::flow
