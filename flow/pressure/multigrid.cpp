#include "samara/flow/pressure/multigrid.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace samara::flow {

namespace {

constexpr int kSweeps = 2;
constexpr int kCoarsestSweeps = 8;

/// x += inverse diagonal (b - A x) at every second cell of a row.
void relax_row(const PoissonMatrix& matrix, Index row, Index start, const double* b, double* x) {
  const Index n = matrix.grid.cells[0], sy = matrix.grid.stride[1], sz = matrix.grid.stride[2];
  const double* const wx = matrix.weight[0].data() + row;
  const double* const wy = matrix.weight[1].data() + row;
  const double* const inverse = matrix.inverse_diagonal.data() + row;
  const double* const right = b + row;
  double* const p = x + row;
  if (matrix.grid.dimensions == 2) {
    for (Index i = start; i < n; i += 2)
      p[i] = inverse[i] * (right[i] + wx[i] * p[i - 1] + wx[i + 1] * p[i + 1] + wy[i] * p[i - sy] +
                           wy[i + sy] * p[i + sy]);
    return;
  }
  const double* const wz = matrix.weight[2].data() + row;
  for (Index i = start; i < n; i += 2)
    p[i] = inverse[i] * (right[i] + wx[i] * p[i - 1] + wx[i + 1] * p[i + 1] + wy[i] * p[i - sy] +
                         wy[i + sy] * p[i + sy] + wz[i] * p[i - sz] + wz[i + sz] * p[i + sz]);
}

}  // namespace

MultigridSolver::Level::Level(PoissonMatrix of)
    : matrix(std::move(of)), x(matrix.grid.field()), b(matrix.grid.field()), residual(matrix.grid.field()) {}

MultigridSolver::MultigridSolver(PoissonMatrix matrix)
    : direction_(matrix.grid.field()), product_(matrix.grid.field()), sums_(matrix.grid) {
  levels_.emplace_back(std::move(matrix));
  while (levels_.back().matrix.grid.cell_count() > 1) levels_.emplace_back(coarsened(levels_.back().matrix));
  count_active_cells();
}

void MultigridSolver::set_matrix(const PoissonMatrix& matrix) {
  PoissonMatrix& own = levels_.front().matrix;
  for (std::size_t d = 0; d < 3; ++d)
    std::copy(matrix.weight[d].begin(), matrix.weight[d].end(), own.weight[d].begin());
  std::copy(matrix.inverse_diagonal.begin(), matrix.inverse_diagonal.end(), own.inverse_diagonal.begin());
  for (std::size_t l = 1; l < levels_.size(); ++l) coarsen(levels_[l - 1].matrix, levels_[l].matrix);
  count_active_cells();
}

void MultigridSolver::count_active_cells() {
  const PoissonMatrix& finest = levels_.front().matrix;
  active_cells_ = sums_.sum(finest.grid, [&](Index row) {
    const double* const inverse = finest.inverse_diagonal.data() + row;
    return static_cast<double>(
        std::count_if(inverse, inverse + finest.grid.cells[0], [](double d) { return d > 0; }));
  });
}

void MultigridSolver::sweep(Level& level, int colour) const {
  const MacGrid& grid = level.matrix.grid;
  level.matrix.fill_margins(level.x);
  for_rows(grid, all_cells(grid), [&](Index row, int r) {
    const int parity = (r % grid.cells[1] + r / grid.cells[1] + colour) % 2;
    relax_row(level.matrix, row, parity, level.b.data(), level.x.data());
  });
}

void MultigridSolver::smooth_down(Level& level, int sweeps) const {
  for (int s = 0; s < sweeps; ++s) {
    sweep(level, 0);
    sweep(level, 1);
  }
}

void MultigridSolver::smooth_up(Level& level, int sweeps) const {
  for (int s = 0; s < sweeps; ++s) {
    sweep(level, 1);
    sweep(level, 0);
  }
}

void MultigridSolver::restrict_residual(Level& fine, Level& coarse) const {
  const MacGrid& grid = fine.matrix.grid;
  const MacGrid& below = coarse.matrix.grid;
  fine.matrix.fill_margins(fine.x);
  for_rows(grid, all_cells(grid), [&](Index row, int) {
    fine.matrix.residual_row(row, fine.b.data(), fine.x.data(), fine.residual.data());
  });
  // A coarse row gathers from its two or four fine rows.
  const int two_y = grid.cells[1] == 1 ? 1 : 2, two_z = grid.cells[2] == 1 ? 1 : 2;
  for_rows(below, all_cells(below), [&](Index row, int r) {
    const int j = r % below.cells[1], k = r / below.cells[1];
    double* const sum = coarse.b.data() + row;
    std::fill(sum, sum + below.cells[0], 0.0);
    for (int kk = two_z * k; kk < std::min(grid.cells[2], two_z * (k + 1)); ++kk) {
      for (int jj = two_y * j; jj < std::min(grid.cells[1], two_y * (j + 1)); ++jj) {
        const double* const from = fine.residual.data() + grid.at(0, jj, kk);
        if (grid.cells[0] == 1) {
          sum[0] += from[0];
          continue;
        }
        const int pairs = grid.cells[0] / 2;
        for (int i = 0; i < pairs; ++i) sum[i] += from[2 * i] + from[2 * i + 1];
        if (grid.cells[0] % 2 == 1) sum[pairs] += from[2 * pairs];
      }
    }
  });
}

void MultigridSolver::prolong(const Level& coarse, Level& fine) const {
  const MacGrid& grid = fine.matrix.grid;
  const MacGrid& below = coarse.matrix.grid;
  const int two_x = grid.cells[0] == 1 ? 1 : 2, two_y = grid.cells[1] == 1 ? 1 : 2,
            two_z = grid.cells[2] == 1 ? 1 : 2;
  for_rows(grid, all_cells(grid), [&](Index row, int r) {
    const double* const from =
        coarse.x.data() + below.at(0, r % grid.cells[1] / two_y, r / grid.cells[1] / two_z);
    double* const to = fine.x.data() + row;
    if (two_x == 1) {
      to[0] += from[0];
      return;
    }
    const int pairs = grid.cells[0] / 2;
    for (int i = 0; i < pairs; ++i) {
      to[2 * i] += from[i];
      to[2 * i + 1] += from[i];
    }
    if (grid.cells[0] % 2 == 1) to[2 * pairs] += from[pairs];
  });
}

void MultigridSolver::cycle() {
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    Level& level = levels_[l];
    std::fill(level.x.begin(), level.x.end(), 0.0);
    const bool coarsest = l + 1 == levels_.size();
    smooth_down(level, coarsest ? kCoarsestSweeps : kSweeps);
    if (!coarsest) restrict_residual(level, levels_[l + 1]);
  }
  smooth_up(levels_.back(), kCoarsestSweeps);
  for (std::size_t l = levels_.size() - 1; l-- > 0;) {
    prolong(levels_[l + 1], levels_[l]);
    smooth_up(levels_[l], kSweeps);
  }
}

double MultigridSolver::dot(const Field& a, const Field& b) {
  const MacGrid& grid = levels_.front().matrix.grid;
  return sums_.sum(grid, [&](Index row) {
    const double* const x = a.data() + row;
    const double* const y = b.data() + row;
    double sum[4] = {};  // four at a time, in an order that is the same everywhere
    Index i = 0;
    for (; i + 4 <= grid.cells[0]; i += 4) {
      for (Index lane = 0; lane < 4; ++lane) sum[lane] += x[i + lane] * y[i + lane];
    }
    for (; i < grid.cells[0]; ++i) sum[0] += x[i] * y[i];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
  });
}

void MultigridSolver::remove_mean(Field& field) {
  const PoissonMatrix& matrix = levels_.front().matrix;
  const double mean = sums_.sum(matrix.grid, [&](Index row) {
    double sum = 0.0;
    for (Index c = row; c < row + matrix.grid.cells[0]; ++c) {
      if (matrix.inverse_diagonal[static_cast<std::size_t>(c)] > 0.0)
        sum += field[static_cast<std::size_t>(c)];
    }
    return sum;
  }) / active_cells_;
  for_rows(matrix.grid, all_cells(matrix.grid), [&](Index row, int) {
    for (Index c = row; c < row + matrix.grid.cells[0]; ++c) {
      if (matrix.inverse_diagonal[static_cast<std::size_t>(c)] > 0.0)
        field[static_cast<std::size_t>(c)] -= mean;
    }
  });
}

PressureSolve MultigridSolver::solve(Field& b, Field& x, double tolerance) {
  const PoissonMatrix& matrix = levels_.front().matrix;
  const MacGrid& grid = matrix.grid;
  const Range cells = all_cells(grid);
  const auto width = static_cast<Index>(grid.cells[0]);
  // The residual lives where the cycle takes its right-hand side, and its answer is the preconditioned residual.
  Field& residual = levels_.front().b;
  const Field& preconditioned = levels_.front().x;
  const auto largest_residual = [&] {
    return sums_.maximum(grid, [&](Index row) { return largest_size(residual.data() + row, width); });
  };
  if (!matrix.fixes_level) remove_mean(b);
  matrix.fill_margins(x);
  for_rows(grid, cells,
           [&](Index row, int) { matrix.residual_row(row, b.data(), x.data(), residual.data()); });

  PressureSolve report;
  report.residual = largest_residual();
  double product_before = 0.0;
  while (report.residual > tolerance && report.iterations < kMostPressureIterations) {
    cycle();
    const double product = dot(residual, preconditioned);
    if (!(product > 0.0)) break;
    const double turn = report.iterations == 0 ? 0.0 : product / product_before;
    product_before = product;
    for_rows(grid, cells, [&](Index row, int) {
      double* const d = direction_.data() + row;
      const double* const z = preconditioned.data() + row;
      for (Index i = 0; i < width; ++i) d[i] = z[i] + turn * d[i];
    });
    matrix.fill_margins(direction_);
    // -A d, as the residual of nothing.
    for_rows(grid, cells, [&](Index row, int) {
      double* const q = product_.data() + row;
      std::fill(q, q + width, 0.0);
      matrix.residual_row(row, product_.data(), direction_.data(), product_.data());
    });
    const double step = -product / dot(direction_, product_);
    for_rows(grid, cells, [&](Index row, int) {
      double* const p = x.data() + row;
      double* const r = residual.data() + row;
      const double* const d = direction_.data() + row;
      const double* const q = product_.data() + row;
      for (Index i = 0; i < width; ++i) {
        p[i] += step * d[i];
        r[i] += step * q[i];
      }
    });
    ++report.iterations;
    report.residual = largest_residual();
  }
  if (!matrix.fixes_level) remove_mean(x);
  matrix.fill_margins(x);
  report.converged = report.residual <= tolerance;
  return report;
}

}  // namespace samara::flow
