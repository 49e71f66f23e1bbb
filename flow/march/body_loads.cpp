#include "samara/flow/march/body_loads.h"

#include <algorithm>
#include <cmath>

#include "samara/flow/grid/rows.h"

namespace samara::flow {

namespace {

/// Place of a cell, or of its lower face of a direction (-1: none).
Eigen::Vector3d place_of(const MacGrid& grid, Index c, int face_direction) {
  const Index inside = c - grid.first + MacGrid::kMargin * (grid.stride[0] + grid.stride[1]) +
                       (grid.dimensions == 3 ? MacGrid::kMargin * grid.stride[2] : 0);
  const Index plane = grid.dimensions == 3 ? grid.stride[2] : grid.size;
  const int margin = MacGrid::kMargin;
  const int i = static_cast<int>(inside % grid.stride[1]) - margin;
  const int j = static_cast<int>(inside % plane / grid.stride[1]) - margin;
  const int k = grid.dimensions == 3 ? static_cast<int>(inside / plane) - margin : 0;
  return face_direction < 0 ? grid.centre(i, j, k) : grid.face_centre(face_direction, i, j, k);
}

/// Collects forces with their moments about a place.
struct Collector {
  const MacGrid& grid;
  Eigen::Vector3d place;
  BodyLoads loads = {};

  void add(int d, double force, Index c, int face_direction) {
    loads.force(d) += force;
    const Eigen::Vector3d arm = place_of(grid, c, face_direction) - place;
    if (d == 0) loads.moment -= arm.y() * force;
    if (d == 1) loads.moment += arm.x() * force;
  }
};

}  // namespace

BodyLoads surface_loads(const MacGrid& grid, const Openness& open, const MomentumStep& momentum,
                        const FlowState& state, const Eigen::Vector3d& place) {
  Collector sum{grid, place};
  const double area = std::pow(grid.spacing, grid.dimensions - 1), volume = area * grid.spacing;
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    for (const WallPiece& cell : open.wall_cells) {
      if (cell.border) continue;
      const double* const a = open.face[at].data() + cell.at;
      const double push = area * state.p[static_cast<std::size_t>(cell.at)] * (a[0] - a[grid.stride[at]]);
      if (push == 0.0) continue;
      sum.add(d, push, cell.at, -1);
      sum.loads.pressure(d) += push;
    }
    for (std::size_t i = 0; i < open.wall_faces[at].size(); ++i) {
      if (open.wall_faces[at][i].border) continue;
      sum.add(d, volume * momentum.wall_loss_taken(state, d, i), open.wall_faces[at][i].at, d);
    }
    for (const Index c : open.closed_faces[at]) {
      double taken = 0.0;
      for (int j = 0; j < grid.dimensions; ++j)
        taken += momentum.flux_taken(state, d, j, c) -
                 momentum.flux_taken(state, d, j, c + grid.stride[static_cast<std::size_t>(j)]);
      if (taken != 0.0) sum.add(d, area * taken, c, d);
    }
  }
  return sum.loads;
}

Eigen::Vector3d box_force(const MacGrid& grid, const Openness& open, const MomentumStep& momentum,
                          const FlowState& state, const Range& box, double step) {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  const double area = std::pow(grid.spacing, grid.dimensions - 1), volume = area * grid.spacing;
  const auto for_places = [&](const Range& range, const auto& body) {
    for (int k = range.begin[2]; k < range.end[2]; ++k) {
      for (int j = range.begin[1]; j < range.end[1]; ++j) {
        for (int i = range.begin[0]; i < range.end[0]; ++i) body(grid.at(i, j, k));
      }
    }
  };
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto own = static_cast<std::size_t>(d);
    double stored = 0.0;
    for_places(box, [&](Index c) {
      const auto f = static_cast<std::size_t>(c);
      const double inverse = open.inverse_volume[own][f];
      if (inverse > 0.0) stored += (state.u[own][f] - state.u_before[own][f]) / inverse;
    });
    double entered = 0.0;
    for (int j = 0; j < grid.dimensions; ++j) {
      const auto across = static_cast<std::size_t>(j);
      Range low = box, high = box;
      low.end[across] = low.begin[across] + 1;
      high.begin[across] = box.end[across];
      high.end[across] = high.begin[across] + 1;
      for_places(low, [&](Index c) {
        entered += momentum.flux_taken(state, d, j, c);
        if (j == d) entered += state.p[static_cast<std::size_t>(c - grid.stride[own])];
      });
      for_places(high, [&](Index c) {
        entered -= momentum.flux_taken(state, d, j, c);
        if (j == d) entered -= state.p[static_cast<std::size_t>(c - grid.stride[own])];
      });
    }
    force(d) = area * entered - volume * stored / step;
  }
  return force;
}

Range control_box(const MacGrid& grid, const PlacedShape& body, int margin_cells) {
  Range box = all_cells(grid);
  const Eigen::Vector3d half = body.half_extent();
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const double low = (body.place()(d) - half(d) - grid.origin(d)) / grid.spacing;
    const double high = (body.place()(d) + half(d) - grid.origin(d)) / grid.spacing;
    box.begin[at] = std::max(2, static_cast<int>(std::floor(low)) - margin_cells);
    box.end[at] = std::min(grid.cells[at] - 2, static_cast<int>(std::ceil(high)) + margin_cells);
  }
  return box;
}

}  // namespace samara::flow
