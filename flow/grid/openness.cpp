#include "samara/flow/grid/openness.h"

#include <algorithm>
#include <cmath>

#include "samara/flow/grid/rows.h"

namespace samara::flow {

namespace {

constexpr double kLeastDistance = 0.05;  // of a velocity from the surface, in cells

template <class Body>
void for_cells(const Range& range, const Body& body) {
  for (int k = range.begin[2]; k < range.end[2]; ++k) {
    for (int j = range.begin[1]; j < range.end[1]; ++j) {
      for (int i = range.begin[0]; i < range.end[0]; ++i) body(i, j, k);
    }
  }
}

/// Cells that a surface may touch, and those beside them.
Range near_of(const MacGrid& grid, const PlacedShape& body) {
  Range near = all_cells(grid);
  const Eigen::Vector3d half = body.half_extent();
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const double low = (body.place()(d) - half(d) - grid.origin(d)) / grid.spacing;
    const double high = (body.place()(d) + half(d) - grid.origin(d)) / grid.spacing;
    near.begin[at] = std::clamp(static_cast<int>(std::floor(low)) - 2, 0, grid.cells[at]);
    near.end[at] = std::clamp(static_cast<int>(std::ceil(high)) + 3, 0, grid.cells[at]);
  }
  return near;
}

/// Signed distances at places of a grid, in cells: exact within three cells of the surface; beyond them of the right
/// sign, and at least three. A distance changes by no more than the way, so that a row leaps over what is far.
class Distances {
 public:
  /// @param offset of the places from the lower corners of cells, in cells
  Distances(const MacGrid& grid, const PlacedShape& body, const Range& near, const Eigen::Vector3d& offset)
      : grid_(grid), near_(near) {
    for (std::size_t d = 0; d < 3; ++d)
      size_[d] = static_cast<int>(d) < grid.dimensions ? near.end[d] - near.begin[d] + 1 : 1;
    values_.resize(static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) *
                   static_cast<std::size_t>(size_[2]));
    constexpr double kExact = 3.0;
    for (int k = 0; k < size_[2]; ++k) {
      for (int j = 0; j < size_[1]; ++j) {
        double bound = 0.0;
        for (int i = 0; i < size_[0]; ++i) {
          bound = std::abs(bound) - 1.0 > kExact ? bound - std::copysign(1.0, bound) : 0.0;
          if (bound == 0.0) {
            Eigen::Vector3d x =
                grid.origin +
                grid.spacing *
                    (Eigen::Vector3d(near.begin[0] + i, near.begin[1] + j, near.begin[2] + k) + offset);
            if (grid.dimensions == 2) x.z() = 0.0;
            bound = body.distance(x) / grid.spacing;
            // A surface on a grid line shall not open its faces by rounding.
            if (std::abs(bound) < 1e-9) bound = 0.0;
          }
          values_[place(i, j, k)] = bound;
        }
      }
    }
  }

  /// At the place of a cell of the range, or of one beyond its end.
  double operator()(int i, int j, int k) const {
    return values_[place(i - near_.begin[0], j - near_.begin[1], k - near_.begin[2])];
  }

  /// Direction in which the distance grows, by differences of neighbours of the range.
  Eigen::Vector3d normal(int i, int j, int k) const {
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();
    for (int d = 0; d < grid_.dimensions; ++d) {
      const auto at = static_cast<std::size_t>(d);
      std::array<int, 3> low = {i, j, k}, high = low;
      low[at] = std::max(low[at] - 1, near_.begin[at]);
      high[at] = std::min(high[at] + 1, near_.end[at]);
      slope(d) = ((*this)(high[0], high[1], high[2]) - (*this)(low[0], low[1], low[2])) /
                 std::max(1, high[at] - low[at]);
    }
    const double size = slope.norm();
    return size > 1e-6 ? Eigen::Vector3d(slope / size) : Eigen::Vector3d::UnitX();
  }

 private:
  std::size_t place(int i, int j, int k) const {
    return static_cast<std::size_t>(i + size_[0] * (j + size_[1] * k));
  }

  const MacGrid& grid_;
  Range near_;
  std::array<int, 3> size_ = {1, 1, 1};
  std::vector<double> values_;
};

/// Share of cell (i, j, k), or of its lower face of a direction (-1: none), that is open.
double share_of(const Distances& corners, int dimensions, int face_direction, int i, int j, int k) {
  double values[8];
  int count = 0;
  const auto reach = [&](int d) { return d < dimensions && d != face_direction ? 1 : 0; };
  for (int c = 0; c <= reach(2); ++c) {
    for (int b = 0; b <= reach(1); ++b) {
      for (int a = 0; a <= reach(0); ++a) values[count++] = corners(i + a, j + b, k + c);
    }
  }
  return open_share(values, count);
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

/// Mean distance in cells of the open part of the cube about a place from the surface.
double mean_distance(const Distances& distances, int dimensions, int i, int j, int k) {
  const OpenPart part = measure_open_part(distances(i, j, k), distances.normal(i, j, k), dimensions);
  return std::max(part.mean_distance, kLeastDistance);
}

void measure_faces(const MacGrid& grid, const Distances& distances, int d, bool baffle, Openness& open) {
  const auto at = static_cast<std::size_t>(d);
  const Index own = grid.stride[at];
  for_cells(open.near, [&](int i, int j, int k) {
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
      open.wall_faces[at].push_back({c, std::sqrt(volume.wall),
                                     grid.spacing * mean_distance(distances, grid.dimensions, i, j, k),
                                     false});
  });
  const auto mean_at = [&](int i, int j, int k) {
    // The velocity of a closed face is that of the surface.
    return open.face[at][static_cast<std::size_t>(grid.at(i, j, k))] == 0.0
               ? 0.0
               : mean_distance(distances, grid.dimensions, i, j, k);
  };
  for_cells(open.near, [&](int i, int j, int k) {
    const Index c = grid.at(i, j, k);
    for (int e = 0; e < grid.dimensions; ++e) {
      const auto across = static_cast<std::size_t>(e);
      const double* const a = open.face[across].data() + c;
      const double area = 0.5 * (a[-own] + a[0]);
      double& conduction = open.conduction[at][across][static_cast<std::size_t>(c)];
      conduction = area;
      const std::array<int, 3> below = {i - (e == 0), j - (e == 1), k - (e == 2)};
      if (baffle || area == 0.0 || below[across] < open.near.begin[across]) continue;
      const double rise = distances(i, j, k) - distances(below[0], below[1], below[2]);
      const double means = mean_at(i, j, k) - mean_at(below[0], below[1], below[2]);
      // Along the surface neither rises, and the quotient says nothing: it is 1 there.
      constexpr double kAlong = 0.01, kMost = 2.5;
      const double far = rise * rise + kAlong, near = means * rise + kAlong;
      conduction *= near * kMost > far ? std::max(1.0, far / near) : kMost;
    }
  });
}

void measure_cells(const MacGrid& grid, const Distances& distances, Openness& open) {
  for_cells(open.near, [&](int i, int j, int k) {
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
      open.wall_cells.push_back({c, std::sqrt(volume.wall),
                                 grid.spacing * mean_distance(distances, grid.dimensions, i, j, k), false});
  });
}

/// All open about where the body was; walls of the domain stay.
void forget_body(const MacGrid& grid, Openness& open) {
  const auto is_of_body = [](const WallPiece& piece) { return !piece.border; };
  std::erase_if(open.wall_cells, is_of_body);
  open.closed_cells.clear();
  for (std::size_t d = 0; d < 3; ++d) {
    std::erase_if(open.wall_faces[d], is_of_body);
    open.closed_faces[d].clear();
  }
  for_cells(open.near, [&](int i, int j, int k) {
    const auto c = static_cast<std::size_t>(grid.at(i, j, k));
    open.cell[c] = open.inverse_cell[c] = 1.0;
    for (std::size_t d = 0; d < static_cast<std::size_t>(grid.dimensions); ++d) {
      open.face[d][c] = open.inverse_volume[d][c] = 1.0;
      for (std::size_t e = 0; e < static_cast<std::size_t>(grid.dimensions); ++e)
        open.conduction[d][e][c] = 1.0;
    }
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
      inverse_cell(grid.field(1.0)) {
  for (int d = 0; d < grid.dimensions; ++d) conduction[static_cast<std::size_t>(d)] = grid.faces(1.0);
}

OpenPart measure_open_part(double distance, const Eigen::Vector3d& normal, int dimensions) {
  // Integrals over a cube of powers of the positive part of a linear function are differences of higher powers over its
  // corners; along directions that the function hardly knows they lose digits, and there it is tilted a little.
  constexpr double kTilt = 1e-3;
  double volume = 0.0, moment = 0.0, slopes = 1.0, reach = 0.0;
  for (int d = 0; d < dimensions; ++d) {
    slopes *= std::max(std::abs(normal(d)), kTilt);
    reach += 0.5 * std::max(std::abs(normal(d)), kTilt);
  }
  if (distance >= reach) return {1.0, distance};
  for (int corner = 0; corner < 1 << dimensions; ++corner) {
    double t = distance, sign = 1.0;
    for (int d = 0; d < dimensions; ++d) {
      const bool high = (corner >> d & 1) != 0;
      t += (high ? 0.5 : -0.5) * std::max(std::abs(normal(d)), kTilt);
      if (!high) sign = -sign;
    }
    if (t <= 0.0) continue;
    const double power = dimensions == 2 ? t * t / 2.0 : t * t * t / 6.0;
    volume += sign * power;
    moment += sign * power * t / (dimensions + 1.0);
  }
  volume = std::clamp(volume / slopes, 0.0, 1.0);
  if (volume < 1e-6) return {volume, 0.0};
  return {volume, moment / slopes / volume};
}

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
  if (body) measure_openness(grid, borders, *body, open);
  return open;
}

void measure_openness(const MacGrid& grid, const Borders& borders, const PlacedShape& body, Openness& open) {
  forget_body(grid, open);
  open.near = near_of(grid, body);
  const Distances corners(grid, body, open.near, Eigen::Vector3d::Zero());
  for_cells(open.near, [&](int i, int j, int k) {
    const Index c = grid.at(i, j, k);
    const auto at = static_cast<std::size_t>(c);
    open.cell[at] = share_of(corners, grid.dimensions, -1, i, j, k);
    for (int d = 0; d < grid.dimensions; ++d) {
      // Centres by one formula: one that lies on a baffle is on the same side for all its faces.
      const Eigen::Vector3d below = grid.centre(i - (d == 0), j - (d == 1), k - (d == 2));
      const double share =
          body.separates(below, grid.centre(i, j, k)) ? 0.0 : share_of(corners, grid.dimensions, d, i, j, k);
      open.face[static_cast<std::size_t>(d)][at] = share < kClosed ? 0.0 : share;
    }
  });
  fill_margins(grid, borders, open.cell);
  for (int d = 0; d < grid.dimensions; ++d)
    fill_margins(grid, borders, open.face[static_cast<std::size_t>(d)]);
  const Eigen::Vector3d middle = Eigen::Vector3d::Constant(0.5);
  for (int d = 0; d < grid.dimensions; ++d) {
    const Distances faces(grid, body, open.near, middle - 0.5 * Eigen::Vector3d::Unit(d));
    measure_faces(grid, faces, d, body.shape().baffle, open);
  }
  measure_cells(grid, Distances(grid, body, open.near, middle), open);
}

}  // namespace samara::flow
