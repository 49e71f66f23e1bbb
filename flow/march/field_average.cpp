#include "samara/flow/march/field_average.h"

#include <algorithm>

#include "samara/flow/grid/rows.h"

namespace samara::flow {

namespace {

/// |u|^2 in the centre of a cell.
double squared_speed(const MacGrid& grid, const FaceField& velocity, Index c) {
  double sum = 0.0;
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const double* const u = velocity[at].data() + c;
    const double middle = 0.5 * (u[0] + u[grid.stride[at]]);
    sum += middle * middle;
  }
  return sum;
}

}  // namespace

FieldAverage::FieldAverage(const MacGrid& grid, bool turbulent)
    : grid_(grid), velocity_(grid.faces()), pressure_(grid.field()), squares_(grid.field()) {
  if (!turbulent) return;
  k_ = grid.field();
  epsilon_ = grid.field();
}

void FieldAverage::add(const FlowMarch& march, double step) {
  time_ += step;
  const FlowState& state = march.state();
  const KEpsilon* const turbulence = march.turbulence();
  Range with_last_row = all_cells(grid_);
  for (int d = 1; d < grid_.dimensions; ++d) with_last_row.end[static_cast<std::size_t>(d)] += 1;
  for_rows(grid_, with_last_row, [&](Index row, int) {
    const Index end = row + grid_.cells[0] + 1;
    for (int d = 0; d < grid_.dimensions; ++d) {
      const auto at = static_cast<std::size_t>(d);
      double* const sum = velocity_[at].data();
      const double* const u = state.u[at].data();
      for (Index c = row; c < end; ++c) sum[c] += step * u[c];
    }
  });
  for_rows(grid_, all_cells(grid_), [&](Index row, int) {
    for (Index c = row; c < row + grid_.cells[0]; ++c) {
      const auto at = static_cast<std::size_t>(c);
      pressure_[at] += step * state.p[at];
      squares_[at] += step * squared_speed(grid_, state.u, c);
      if (turbulence == nullptr) continue;
      k_[at] += step * turbulence->k[at];
      epsilon_[at] += step * turbulence->epsilon[at];
    }
  });
}

Field FieldAverage::over_time(const Field& sum) const {
  Field mean = sum;
  for (double& value : mean) value /= time_;
  return mean;
}

FaceField FieldAverage::velocity() const {
  return {over_time(velocity_[0]), over_time(velocity_[1]), over_time(velocity_[2])};
}

Field FieldAverage::k_resolved() const {
  const FaceField mean = velocity();
  Field energy = grid_.field();
  for_rows(grid_, all_cells(grid_), [&](Index row, int) {
    for (Index c = row; c < row + grid_.cells[0]; ++c) {
      const auto at = static_cast<std::size_t>(c);
      energy[at] = 0.5 * std::max(0.0, squares_[at] / time_ - squared_speed(grid_, mean, c));
    }
  });
  return energy;
}

}  // namespace samara::flow
