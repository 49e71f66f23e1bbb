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

/// The same in the plane, by eights: the cells between are written as they were, so that nobody else may look at the
/// row.
void relax_row_by_eights(const PoissonMatrix& matrix, Index row, Index start, const double* b, double* x) {
  using Places = long long __attribute__((vector_size(64)));
  constexpr Places kEven = {-1, 0, -1, 0, -1, 0, -1, 0};
  const Places taken = start == 0 ? kEven : ~kEven;
  const Index n = matrix.grid.cells[0], whole = n / kEight * kEight, sy = matrix.grid.stride[1];
  const double* const wx = matrix.weight[0].data() + row;
  const double* const wy = matrix.weight[1].data() + row;
  const double* const inverse = matrix.inverse_diagonal.data() + row;
  const double* const right = b + row;
  double* const p = x + row;
  const Eight none = {};
  Eight last = none + p[-1];
  // Neighbours in the row by shifts: what has just been written cannot be read across its border at once.
  for (Index i = 0; i < whole; i += kEight) {
    const Eight now = load<Eight>(p + i), weight = load<Eight>(wx + i);
    const Eight before = __builtin_shufflevector(last, now, 7, 8, 9, 10, 11, 12, 13, 14);
    const Eight after = __builtin_shufflevector(now, none + p[i + kEight], 1, 2, 3, 4, 5, 6, 7, 8);
    const Eight weight_after = __builtin_shufflevector(weight, none + wx[i + kEight], 1, 2, 3, 4, 5, 6, 7, 8);
    const Eight found =
        load<Eight>(inverse + i) *
        (load<Eight>(right + i) + weight * before + weight_after * after +
         load<Eight>(wy + i) * load<Eight>(p + i - sy) + load<Eight>(wy + i + sy) * load<Eight>(p + i + sy));
    store<Eight>(taken ? found : now, p + i);
    last = now;
  }
  for (Index i = whole + start; i < n; i += 2)
    p[i] = inverse[i] *
           (right[i] + wx[i] * p[i - 1] + wx[i + 1] * p[i + 1] + wy[i] * p[i - sy] + wy[i + sy] * p[i + sy]);
}

/// The same from x = 0, at the other cells of the row as well.
void start_row(const PoissonMatrix& matrix, Index row, Index start, const double* b, double* x) {
  const Index n = matrix.grid.cells[0];
  std::fill(x + row, x + row + n, 0.0);
  for (Index c = row + start; c < row + n; c += 2)
    x[c] = matrix.inverse_diagonal[static_cast<std::size_t>(c)] * b[c];
}

double dot_of_row(const double* x, const double* y, Index count) {
  double sum[kEight] = {};
  by_eights(0, count,
            [&]<class V>(Index i) { store<V>(load<V>(sum) + load<V>(x + i) * load<V>(y + i), sum); });
  return sum_of(sum);
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

/// Half-sweeps over one colour after the other. A row is done with a half-sweep when its neighbours are with the one
/// before: in the plane all of them go over the grid together, each a row behind the one before it, while the rows
/// are near. The numbers are those of one after the other.
void MultigridSolver::smooth(Level& level, int sweeps, int first_colour, bool from_zero) const {
  const PoissonMatrix& matrix = level.matrix;
  const MacGrid& grid = matrix.grid;
  const int halves = 2 * sweeps, rows = grid.cells[1];
  if (grid.dimensions == 3 || matrix.periodic[0] || matrix.periodic[1]) {
    if (from_zero) std::fill(level.x.begin(), level.x.end(), 0.0);
    for (int half = 0; half < halves; ++half) sweep(level, (first_colour + half) % 2);
    return;
  }
  const auto relax = [&](int row, int half) {
    const Index place = grid.at(0, row), start = (row + first_colour + half) % 2;
    if (from_zero && half == 0) return start_row(matrix, place, start, level.b.data(), level.x.data());
    (kHasEights ? relax_row_by_eights : relax_row)(matrix, place, start, level.b.data(), level.x.data());
  };
  // Blocks stop a row earlier with every half-sweep, and look at no rows of others, which may be ahead or behind..
  const int together = std::max(32, 2 * halves + 2), blocks = std::max(1, rows / together);
  const auto act = [&](int block) {
    const int begin = block * together, end = block + 1 == blocks ? rows : begin + together;
    for (int lead = begin; lead < end + halves - 1; ++lead) {
      for (int half = 0; half < halves; ++half) {
        const int low = begin > 0 ? begin + half + 1 : 0, high = end < rows ? end - half - 1 : rows;
        if (lead - half >= low && lead - half < high) relax(lead - half, half);
      }
    }
  };
  // ..and what is left lies in wedges between them, which do not touch each other.
  const auto close = [&](int gap) {
    const int border = (gap + 1) * together;
    for (int half = 0; half < halves; ++half) {
      for (int row = border - half - 1; row <= border + half; ++row) relax(row, half);
    }
  };
  if (blocks == 1) return act(0);
  parallel_for(blocks, act);
  parallel_for(blocks - 1, close);
}

void MultigridSolver::restrict_residual(Level& fine, Level& coarse) const {
  const MacGrid& grid = fine.matrix.grid;
  const MacGrid& below = coarse.matrix.grid;
  fine.matrix.fill_margins(fine.x);
  // A coarse row gathers from its two or four fine rows.
  const int two_y = grid.cells[1] == 1 ? 1 : 2, two_z = grid.cells[2] == 1 ? 1 : 2;
  for_rows(below, all_cells(below), [&](Index row, int r) {
    const int j = r % below.cells[1], k = r / below.cells[1];
    double* const sum = coarse.b.data() + row;
    std::fill(sum, sum + below.cells[0], 0.0);
    for (int kk = two_z * k; kk < std::min(grid.cells[2], two_z * (k + 1)); ++kk) {
      for (int jj = two_y * j; jj < std::min(grid.cells[1], two_y * (j + 1)); ++jj) {
        fine.matrix.residual_row(grid.at(0, jj, kk), fine.b.data(), fine.x.data(), fine.residual.data());
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
    const bool coarsest = l + 1 == levels_.size();
    smooth(level, coarsest ? kCoarsestSweeps : kSweeps, 0, true);
    if (!coarsest) restrict_residual(level, levels_[l + 1]);
  }
  smooth(levels_.back(), kCoarsestSweeps, 1, false);
  for (std::size_t l = levels_.size() - 1; l-- > 0;) {
    prolong(levels_[l + 1], levels_[l]);
    smooth(levels_[l], kSweeps, 1, false);
  }
}

double MultigridSolver::dot(const Field& a, const Field& b) {
  const MacGrid& grid = levels_.front().matrix.grid;
  return sums_.sum(grid,
                   [&](Index row) { return dot_of_row(a.data() + row, b.data() + row, grid.cells[0]); });
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
  if (!matrix.fixes_level) remove_mean(b);
  matrix.fill_margins(x);
  PressureSolve report;
  report.residual = sums_.maximum(grid, [&](Index row) {
    matrix.residual_row(row, b.data(), x.data(), residual.data());
    return largest_size(residual.data() + row, width);
  });
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
    const double fall = sums_.sum(grid, [&](Index row) {
      double* const q = product_.data() + row;
      std::fill(q, q + width, 0.0);
      matrix.residual_row(row, product_.data(), direction_.data(), product_.data());
      return dot_of_row(direction_.data() + row, q, width);
    });
    const double step = -product / fall;
    ++report.iterations;
    report.residual = sums_.maximum(grid, [&](Index row) {
      double* const p = x.data() + row;
      double* const r = residual.data() + row;
      const double* const d = direction_.data() + row;
      const double* const q = product_.data() + row;
      for (Index i = 0; i < width; ++i) {
        p[i] += step * d[i];
        r[i] += step * q[i];
      }
      return largest_size(r, width);
    });
  }
  if (!matrix.fixes_level) remove_mean(x);
  matrix.fill_margins(x);
  report.converged = report.residual <= tolerance;
  return report;
}

}  // namespace samara::flow
