#include "samara/flow/grid/openness.h"

#include <algorithm>
#include <cmath>

#include "samara/flow/grid/rows.h"

namespace samara::flow {

namespace {

/// Signed distances at the lower corners of cells; far from the body just "far".
class CornerDistances {
 public:
  CornerDistances(const MacGrid& grid, const PlacedShape& body)
      : grid_(grid), values_(grid.field(1e30)), near_({{0, 0, 0}, grid.cells}) {
    const Eigen::Vector3d half = body.half_extent();
    for (int d = 0; d < grid.dimensions; ++d) {
      const auto at = static_cast<std::size_t>(d);
      const double low = (body.place()(d) - half(d) - grid.origin(d)) / grid.spacing;
      const double high = (body.place()(d) + half(d) - grid.origin(d)) / grid.spacing;
      near_.begin[at] = std::clamp(static_cast<int>(std::floor(low)) - 2, 0, grid.cells[at]);
      near_.end[at] = std::clamp(static_cast<int>(std::ceil(high)) + 3, 0, grid.cells[at]);
    }
    for_corners([&](int i, int j, int k, Index c) {
      Eigen::Vector3d x = grid.origin + grid.spacing * Eigen::Vector3d(i, j, k);
      if (grid.dimensions == 2) x.z() = 0.0;
      const double distance = body.distance(x);
      // A surface on a grid line shall not open its faces by rounding.
      values_[static_cast<std::size_t>(c)] = std::abs(distance) < 1e-9 * grid.spacing ? 0.0 : distance;
    });
  }

  /// Cells that a surface may touch.
  const Range& near() const { return near_; }

  /// Share of cell c, or of its lower face of a direction, that is open.
  double share(Index c, int face_direction) const {
    double corners[8];
    int count = 0;
    const auto reach = [&](int d) { return d < grid_.dimensions && d != face_direction ? 1 : 0; };
    for (int k = 0; k <= reach(2); ++k) {
      for (int j = 0; j <= reach(1); ++j) {
        for (int i = 0; i <= reach(0); ++i) {
          corners[count++] = values_[static_cast<std::size_t>(c + i * grid_.stride[0] + j * grid_.stride[1] +
                                                              k * grid_.stride[2])];
        }
      }
    }
    return open_share(corners, count);
  }

 private:
  template <class Body>
  void for_corners(const Body& body) const {
    const int top = grid_.dimensions == 3 ? near_.end[2] : 0;
    for (int k = near_.begin[2]; k <= top; ++k) {
      for (int j = near_.begin[1]; j <= near_.end[1]; ++j) {
        for (int i = near_.begin[0]; i <= near_.end[0]; ++i) body(i, j, k, grid_.at(i, j, k));
      }
    }
  }

  const MacGrid& grid_;
  Field values_;
  Range near_;
};

template <class Body>
void for_cells(const Range& range, const Body& body) {
  for (int k = range.begin[2]; k < range.end[2]; ++k) {
    for (int j = range.begin[1]; j < range.end[1]; ++j) {
      for (int i = range.begin[0]; i < range.end[0]; ++i) body(i, j, k);
    }
  }
}

/// Mean distance from the surface over the open part of a cube of edge h about a centre.
double mean_distance(const MacGrid& grid, const PlacedShape& body, const Eigen::Vector3d& centre) {
  const int samples = grid.dimensions == 3 ? 4 : 6;  // along each direction
  double sum = 0.0;
  int open = 0;
  const int layers = grid.dimensions == 3 ? samples : 1;
  for (int k = 0; k < layers; ++k) {
    for (int j = 0; j < samples; ++j) {
      for (int i = 0; i < samples; ++i) {
        Eigen::Vector3d x =
            Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5) / samples - Eigen::Vector3d::Constant(0.5);
        if (grid.dimensions == 2) x.z() = 0.0;
        const double distance = body.distance(centre + grid.spacing * x);
        if (distance <= 0.0) continue;
        sum += distance;
        ++open;
      }
    }
  }
  return open > 0 ? std::max(sum / open, 0.05 * grid.spacing) : 0.05 * grid.spacing;
}

/// Areas and volumes of the control volume of a face, or of a cell.
struct ControlVolume {
  double wall = 0.0;     ///< area of the surface in it: open faces of a closed volume sum to 0 with it
  double largest = 0.0;  ///< of its open faces
};

/// @param low, high open shares of the faces across one direction
void add_direction(ControlVolume& volume, double low, double high) {
  volume.wall += (high - low) * (high - low);
  volume.largest = std::max({volume.largest, low, high});
}

void measure_faces(const MacGrid& grid, const PlacedShape& body, const Range& near, int d, Openness& open) {
  const auto at = static_cast<std::size_t>(d);
  const Index own = grid.stride[at];
  for_cells(near, [&](int i, int j, int k) {
    const Index c = grid.at(i, j, k);
    const auto f = static_cast<std::size_t>(c);
    if (open.face[at][f] == 0.0) {
      open.inverse_volume[at][f] = 0.0;
      open.closed_faces[at].push_back(c);
      return;
    }
    ControlVolume volume;
    for (int e = 0; e < grid.dimensions; ++e) {
      const auto across = static_cast<std::size_t>(e);
      const Index s = grid.stride[across];
      const double* a = open.face[across].data() + c;
      add_direction(volume, 0.5 * (a[-own] + a[0]), 0.5 * (a[s - own] + a[s]));
    }
    const double halves = 0.5 * (open.cell[static_cast<std::size_t>(c - own)] + open.cell[f]);
    open.inverse_volume[at][f] = 1.0 / std::max(halves, 0.5 * volume.largest);
    if (volume.wall > 1e-12)
      open.wall_faces[at].push_back(
          {c, std::sqrt(volume.wall), mean_distance(grid, body, grid.face_centre(d, i, j, k)), false});
  });
}

void measure_cells(const MacGrid& grid, const PlacedShape& body, const Range& near, Openness& open) {
  for_cells(near, [&](int i, int j, int k) {
    const Index c = grid.at(i, j, k);
    const auto at = static_cast<std::size_t>(c);
    ControlVolume volume;
    for (int e = 0; e < grid.dimensions; ++e) {
      const auto across = static_cast<std::size_t>(e);
      const double* a = open.face[across].data() + c;
      add_direction(volume, a[0], a[grid.stride[across]]);
    }
    if (volume.largest == 0.0) {
      open.cell[at] = open.inverse_cell[at] = 0.0;
      open.closed_cells.push_back(c);
      return;
    }
    open.inverse_cell[at] = 1.0 / std::max(open.cell[at], 0.5 * volume.largest);
    if (volume.wall > 1e-12)
      open.wall_cells.push_back(
          {c, std::sqrt(volume.wall), mean_distance(grid, body, grid.centre(i, j, k)), false});
  });
}

/// Walls of the domain that are seen through the law of the wall.
void add_border_walls(const MacGrid& grid, const Borders& borders, Openness& open) {
  for (int side = 0; side < 2 * grid.dimensions; ++side) {
    const Border& border = borders.side[static_cast<std::size_t>(side)];
    if (border.kind != BorderKind::wall || !border.wall_law) continue;
    const auto across = static_cast<std::size_t>(side / 2);
    Range layer = all_cells(grid);
    if (side % 2 == 0)
      layer.end[across] = 1;
    else
      layer.begin[across] = grid.cells[across] - 1;
    for_cells(layer, [&](int i, int j, int k) {
      const WallPiece piece{grid.at(i, j, k), 1.0, 0.5 * grid.spacing, true};
      open.wall_cells.push_back(piece);
      for (std::size_t d = 0; d < static_cast<std::size_t>(grid.dimensions); ++d) {
        if (d != across) open.wall_faces[d].push_back(piece);
      }
    });
  }
}

}  // namespace

Openness::Openness(const MacGrid& grid)
    : face(grid.faces(1.0)),
      cell(grid.field(1.0)),
      inverse_volume(grid.faces(1.0)),
      inverse_cell(grid.field(1.0)) {}

double open_share(const double* corner_distances, int corners) {
  double sum = 0.0, least = corner_distances[0], largest = corner_distances[0];
  for (int i = 0; i < corners; ++i) {
    sum += corner_distances[i];
    least = std::min(least, corner_distances[i]);
    largest = std::max(largest, corner_distances[i]);
  }
  if (largest <= 0.0) return 0.0;
  if (least >= 0.0) return 1.0;
  return std::clamp(0.5 + sum / corners / (largest - least), 0.0, 1.0);
}

Openness measure_openness(const MacGrid& grid, const Borders& borders,
                          const std::optional<PlacedShape>& body) {
  Openness open(grid);
  add_border_walls(grid, borders, open);
  if (!body) return open;
  const CornerDistances corners(grid, *body);
  for_cells(corners.near(), [&](int i, int j, int k) {
    const Index c = grid.at(i, j, k);
    const auto at = static_cast<std::size_t>(c);
    open.cell[at] = corners.share(c, -1);
    for (int d = 0; d < grid.dimensions; ++d) {
      // Centres by one formula: one that lies on a baffle is on the same side for all its faces.
      const Eigen::Vector3d below = grid.centre(i - (d == 0), j - (d == 1), k - (d == 2));
      const double share = body->separates(below, grid.centre(i, j, k)) ? 0.0 : corners.share(c, d);
      open.face[static_cast<std::size_t>(d)][at] = share < kClosed ? 0.0 : share;
    }
  });
  fill_margins(grid, borders, open.cell);
  for (int d = 0; d < grid.dimensions; ++d)
    fill_margins(grid, borders, open.face[static_cast<std::size_t>(d)]);
  for (int d = 0; d < grid.dimensions; ++d) measure_faces(grid, *body, corners.near(), d, open);
  measure_cells(grid, *body, corners.near(), open);
  return open;
}

}  // namespace samara::flow
