#include "samara/flow/momentum/projection.h"

#include <algorithm>
#include <cmath>

#include "samara/flow/grid/rows.h"

namespace samara::flow {

namespace {

/// Sum of a u over the faces of the cells of a row, outward.
void outflow_of_row(const MacGrid& grid, const Openness& open, const FaceField& velocity, Index row,
                    double* out) {
  const Index width = grid.cells[0];
  std::fill(out, out + width, 0.0);
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const Index s = grid.stride[at];
    const double* const u = velocity[at].data() + row;
    const double* const a = open.face[at].data() + row;
    for (Index i = 0; i < width; ++i) out[i] += a[i + s] * u[i + s] - a[i] * u[i];
  }
}

}  // namespace

Projection::Projection(const MacGrid& grid, const Borders& borders, const Openness& open,
                       PressureSolverKind kind)
    : grid_(grid),
      borders_(borders),
      open_(open),
      matrix_(pressure_matrix(grid, borders, open.face, open.inverse_volume)),
      solver_(make_pressure_solver(kind, matrix_)),
      source_(grid.field()),
      sums_(grid) {}

void Projection::follow_body(const BodyPose& pose) {
  set_weights(borders_, open_.face, open_.inverse_volume, matrix_);
  solver_->set_matrix(matrix_);
  swept_.clear();
  const Range& near = open_.near;
  for (int k = near.begin[2]; k < near.end[2]; ++k) {
    for (int j = near.begin[1]; j < near.end[1]; ++j) {
      for (int i = near.begin[0]; i < near.end[0]; ++i) {
        const Index c = grid_.at(i, j, k);
        // Of a cell without open faces the sum is 0, which rounding would hide.
        if (matrix_.inverse_diagonal[static_cast<std::size_t>(c)] == 0.0) continue;
        double sum = 0.0;
        bool cut = false;
        for (int d = 0; d < grid_.dimensions; ++d) {
          const auto at = static_cast<std::size_t>(d);
          for (const int high : {0, 1}) {
            const Index f = c + high * grid_.stride[at];
            const double closed = 1.0 - open_.face[at][static_cast<std::size_t>(f)];
            if (closed == 0.0) continue;
            cut = true;
            sum += (high == 1 ? closed : -closed) * pose.velocity_at(grid_.place(f, d))(d);
          }
        }
        if (cut) swept_.emplace_back(c, sum);
      }
    }
  }
}

/// To what flows out of cells.
void Projection::add_swept(double factor) {
  for (const auto& [cell, sum] : swept_) source_[static_cast<std::size_t>(cell)] += factor * sum;
}

PressureSolve Projection::project(FlowState& state, double step, double tolerance) {
  const Range cells = all_cells(grid_);
  const double per_step = grid_.spacing / step, gradient = step / grid_.spacing;
  // Both ends of a periodic direction are one face, of which the first has been solved for.
  for (int d = 0; d < grid_.dimensions; ++d) {
    if (borders_.periodic(d)) fill_margins(grid_, borders_, state.u);
  }
  for_rows(grid_, cells, [&](Index row, int) {
    double* const b = source_.data() + row;
    outflow_of_row(grid_, open_, state.u, row, b);
    for (Index i = 0; i < grid_.cells[0]; ++i) b[i] *= -per_step;
  });
  add_swept(-per_step);
  const PressureSolve report = solver_->solve(source_, state.p_change, tolerance * per_step);
  for (int d = 0; d < grid_.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const Index s = grid_.stride[at];
    Range faces = cells;
    if (!borders_.periodic(d)) faces.begin[at] = 1;
    for_rows(grid_, faces, [&](Index row, int) {
      double* const u = state.u[at].data() + row;
      const double* const a = open_.face[at].data() + row;
      const double* const inverse = open_.inverse_volume[at].data() + row;
      const double* const q = state.p_change.data() + row;
      for (Index i = 0; i < faces.width(); ++i) u[i] -= gradient * a[i] * inverse[i] * (q[i] - q[i - s]);
    });
    if (borders_.high(d).kind != BorderKind::outflow) continue;
    faces.begin[at] = grid_.cells[at];
    faces.end[at] = faces.begin[at] + 1;
    for_rows(grid_, faces, [&](Index row, int) {
      double* const u = state.u[at].data() + row;
      const double* const inside = state.p_change.data() + row - s;
      for (Index i = 0; i < faces.width(); ++i) u[i] += 2.0 * gradient * inside[i];
    });
  }
  for_rows(grid_, cells, [&](Index row, int) {
    for (Index c = row; c < row + grid_.cells[0]; ++c)
      state.p[static_cast<std::size_t>(c)] += state.p_change[static_cast<std::size_t>(c)];
  });
  fill_margins(grid_, borders_, state.p);
  fill_margins(grid_, borders_, state.u);
  return report;
}

double Projection::divergence(const FlowState& state) {
  for_rows(grid_, all_cells(grid_),
           [&](Index row, int) { outflow_of_row(grid_, open_, state.u, row, source_.data() + row); });
  add_swept(1.0);
  return sums_.maximum(grid_, [&](Index row) { return largest_size(source_.data() + row, grid_.cells[0]); });
}

}  // namespace samara::flow
