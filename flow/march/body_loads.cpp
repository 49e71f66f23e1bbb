#include "samara/flow/march/body_loads.h"

#include <algorithm>
#include <cmath>

#include "samara/flow/grid/rows.h"

namespace samara::flow {

namespace {

/// Collects forces with their moments about a place.
struct Collector {
  const MacGrid& grid;
  Eigen::Vector3d place;
  BodyLoads loads = {};

  void add(int d, double force, Index c, int face_direction) {
    loads.force(d) += force;
    const Eigen::Vector3d arm = grid.place(c, face_direction) - place;
    if (d == 0) loads.moment -= arm.y() * force;
    if (d == 1) loads.moment += arm.x() * force;
  }
};

/// Of the control volume of a closed face, what is left open in h^dimensions.
double closed_volume(const MacGrid& grid, const Openness& open, int d, Index c) {
  const double* const share = open.cell.data() + c;
  return 0.5 * (share[-grid.stride[static_cast<std::size_t>(d)]] + share[0]);
}

/// Momentum per area that the fluid within the control volume of a closed face gains: it moves as the body does.
double closed_storage(const MacGrid& grid, const Openness& open, const MomentumStep& momentum,
                      const BodyPose& pose, int d, Index c) {
  const Eigen::Vector3d x = grid.place(c, d);
  return pose.velocity_at(x)(d) * momentum.volume_taken(d, c) +
         grid.spacing * closed_volume(grid, open, d, c) * pose.acceleration_at(x)(d);
}

template <class Act>
void for_range(const MacGrid& grid, const Range& range, const Act& act) {
  for (int k = range.begin[2]; k < range.end[2]; ++k) {
    for (int j = range.begin[1]; j < range.end[1]; ++j) {
      for (int i = range.begin[0]; i < range.end[0]; ++i) act(grid.at(i, j, k));
    }
  }
}

}  // namespace

void VolumesBefore::keep(const MacGrid& grid, const Openness& open) {
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    for_range(grid, kept_, [&](Index c) { volume_[at][static_cast<std::size_t>(c)] = 1.0; });
    for_range(grid, open.near, [&](Index c) {
      const auto f = static_cast<std::size_t>(c);
      const double inverse = open.inverse_volume[at][f];
      volume_[at][f] = inverse > 0.0 ? 1.0 / inverse : closed_volume(grid, open, d, c);
    });
    closed_[at] = open.closed_faces[at];
  }
  kept_ = open.near;
}

bool VolumesBefore::was_closed(int d, Index c) const {
  return std::ranges::binary_search(closed_[static_cast<std::size_t>(d)], c);
}

std::vector<FaceForce> reshaping_forces(const MacGrid& grid, const Openness& open,
                                        const VolumesBefore& before, const MomentumStep& momentum,
                                        const FlowState& state, const BodyPose& pose, double step) {
  std::vector<FaceForce> forces;
  const double cell = std::pow(grid.spacing, grid.dimensions);
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    for_range(grid, open.near, [&](Index c) {
      const auto f = static_cast<std::size_t>(c);
      const double inverse = open.inverse_volume[at][f];
      const bool was_closed = before.was_closed(d, c);
      if (inverse == 0.0 && was_closed) return;
      const double volume = before.volume(d, c);
      if (inverse == 1.0 && volume == 1.0) return;
      const Eigen::Vector3d x = grid.place(c, d);
      const double of_body = pose.velocity_at(x)(d), slip = state.u_before[at][f] - of_body;
      double rate;
      if (inverse > 0.0) {
        rate = (1.0 / inverse - volume) / step * slip -
               momentum.volume_taken(d, c) / grid.spacing * (momentum.carried(d, c) - of_body);
      } else {
        rate = -volume / step * slip - closed_volume(grid, open, d, c) * pose.acceleration_at(x)(d);
      }
      if (rate != 0.0) forces.push_back({d, c, -cell * rate});
    });
  }
  return forces;
}

BodyLoads surface_loads(const MacGrid& grid, const Openness& open, const MomentumStep& momentum,
                        const FlowState& state, const BodyPose& pose, bool moves,
                        const std::vector<FaceForce>& reshaping) {
  Collector sum{grid, pose.place};
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
      if (moves) taken -= closed_storage(grid, open, momentum, pose, d, c);
      if (taken != 0.0) sum.add(d, area * taken, c, d);
    }
  }
  for (const FaceForce& part : reshaping) sum.add(part.d, part.force, part.at, part.d);
  return sum.loads;
}

Eigen::Vector3d box_force(const MacGrid& grid, const Openness& open, const MomentumStep& momentum,
                          const FlowState& state, const BodyPose& pose, bool moves,
                          const std::vector<FaceForce>& reshaping, const Range& box, double step) {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  const double area = std::pow(grid.spacing, grid.dimensions - 1), volume = area * grid.spacing;
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto own = static_cast<std::size_t>(d);
    double stored = 0.0;
    for_range(grid, box, [&](Index c) {
      const auto f = static_cast<std::size_t>(c);
      const double inverse = open.inverse_volume[own][f];
      if (inverse > 0.0) stored += (state.u[own][f] - state.u_before[own][f]) / inverse;
    });
    double entered = 0.0;
    if (moves) {
      // Volumes grow by what flows in, which beside the body is not what flows out.
      Range near = open.near;
      for (std::size_t e = 0; e < 3; ++e) {
        near.begin[e] = std::max(near.begin[e], box.begin[e]);
        near.end[e] = std::min(near.end[e], box.end[e]);
      }
      for_range(grid, near, [&](Index c) {
        if (open.inverse_volume[own][static_cast<std::size_t>(c)] > 0.0)
          entered -= momentum.carried(d, c) * momentum.volume_taken(d, c);
      });
      for (const Index c : open.closed_faces[own])
        entered -= closed_storage(grid, open, momentum, pose, d, c);
    }
    for (int j = 0; j < grid.dimensions; ++j) {
      const auto across = static_cast<std::size_t>(j);
      Range low = box, high = box;
      low.end[across] = low.begin[across] + 1;
      high.begin[across] = box.end[across];
      high.end[across] = high.begin[across] + 1;
      for_range(grid, low, [&](Index c) {
        entered += momentum.flux_taken(state, d, j, c);
        if (j == d) entered += state.p[static_cast<std::size_t>(c - grid.stride[own])];
      });
      for_range(grid, high, [&](Index c) {
        entered -= momentum.flux_taken(state, d, j, c);
        if (j == d) entered -= state.p[static_cast<std::size_t>(c - grid.stride[own])];
      });
    }
    force(d) = area * entered - volume * stored / step;
  }
  for (const FaceForce& part : reshaping) force(part.d) += part.force;
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
