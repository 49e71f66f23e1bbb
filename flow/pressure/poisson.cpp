#include "samara/flow/pressure/poisson.h"

#include <algorithm>

#include "samara/flow/grid/rows.h"

namespace samara::flow {

void PoissonMatrix::set_diagonal() {
  for_rows(grid, all_cells(grid), [&](Index row, int) {
    for (Index c = row; c < row + grid.cells[0]; ++c) {
      double sum = 0.0;
      for (int d = 0; d < grid.dimensions; ++d) {
        const auto at = static_cast<std::size_t>(d);
        sum += weight[at][static_cast<std::size_t>(c)] +
               weight[at][static_cast<std::size_t>(c + grid.stride[at])];
      }
      inverse_diagonal[static_cast<std::size_t>(c)] = sum > 0.0 ? 1.0 / sum : 0.0;
    }
  });
}

void PoissonMatrix::fill_margins(Field& x) const {
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    if (!periodic[at]) continue;
    const Index s = grid.stride[at], n = grid.cells[at];
    std::array<int, 3> end = grid.cells;
    end[at] = 1;
    for (int k = 0; k < end[2]; ++k) {
      for (int j = 0; j < end[1]; ++j) {
        for (int i = 0; i < end[0]; ++i) {
          double* const line = x.data() + grid.at(i, j, k);
          line[-s] = line[(n - 1) * s];
          line[n * s] = line[0];
        }
      }
    }
  }
}

void PoissonMatrix::residual_row(Index row, const double* b, const double* x, double* r) const {
  const Index n = grid.cells[0], sy = grid.stride[1], sz = grid.stride[2];
  const double* const wx = weight[0].data() + row;
  const double* const wy = weight[1].data() + row;
  const double* const p = x + row;
  const double* const right = b + row;
  double* const left = r + row;
  if (grid.dimensions == 2) {
    for (Index i = 0; i < n; ++i)
      left[i] = right[i] - wx[i] * (p[i] - p[i - 1]) - wx[i + 1] * (p[i] - p[i + 1]) -
                wy[i] * (p[i] - p[i - sy]) - wy[i + sy] * (p[i] - p[i + sy]);
    return;
  }
  const double* const wz = weight[2].data() + row;
  for (Index i = 0; i < n; ++i)
    left[i] = right[i] - wx[i] * (p[i] - p[i - 1]) - wx[i + 1] * (p[i] - p[i + 1]) -
              wy[i] * (p[i] - p[i - sy]) - wy[i + sy] * (p[i] - p[i + sy]) - wz[i] * (p[i] - p[i - sz]) -
              wz[i + sz] * (p[i] - p[i + sz]);
}

PoissonMatrix pressure_matrix(const MacGrid& grid, const Borders& borders, const FaceField& face,
                              const FaceField& inverse_volume) {
  PoissonMatrix matrix(grid);
  for (int d = 0; d < grid.dimensions; ++d)
    matrix.periodic[static_cast<std::size_t>(d)] = borders.periodic(d);
  matrix.fixes_level = borders.has_outflow();
  set_weights(borders, face, inverse_volume, matrix);
  return matrix;
}

void set_weights(const Borders& borders, const FaceField& face, const FaceField& inverse_volume,
                 PoissonMatrix& matrix) {
  const MacGrid& grid = matrix.grid;
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    Range faces = all_cells(grid);
    faces.end[at] += 1;
    for (int k = faces.begin[2]; k < faces.end[2]; ++k) {
      for (int j = faces.begin[1]; j < faces.end[1]; ++j) {
        for (int i = faces.begin[0]; i < faces.end[0]; ++i) {
          const std::array<int, 3> place = {i, j, k};
          const auto f = static_cast<std::size_t>(grid.at(i, j, k));
          const double a = face[at][f];
          double w = a * a * inverse_volume[at][f];
          if (!matrix.periodic[at] && place[at] == 0) w = 0.0;
          if (!matrix.periodic[at] && place[at] == grid.cells[at])
            w = borders.high(d).kind == BorderKind::outflow ? 2.0 * w : 0.0;
          matrix.weight[at][f] = w;
        }
      }
    }
  }
  matrix.set_diagonal();
}

PoissonMatrix coarsened(const PoissonMatrix& fine) {
  std::array<int, 3> cells = fine.grid.cells;
  for (int d = 0; d < fine.grid.dimensions; ++d) {
    int& count = cells[static_cast<std::size_t>(d)];
    if (count > 1) count = (count + 1) / 2;
  }
  PoissonMatrix coarse(MacGrid(fine.grid.dimensions, cells, 2.0 * fine.grid.spacing, fine.grid.origin));
  coarse.periodic = fine.periodic;
  coarse.fixes_level = fine.fixes_level;
  coarsen(fine, coarse);
  return coarse;
}

void coarsen(const PoissonMatrix& fine, PoissonMatrix& coarse) {
  std::array<int, 3> factor = {1, 1, 1};
  for (std::size_t d = 0; d < 3; ++d) factor[d] = coarse.grid.cells[d] < fine.grid.cells[d] ? 2 : 1;
  for (int d = 0; d < fine.grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    std::fill(coarse.weight[at].begin(), coarse.weight[at].end(), 0.0);
    Range faces = all_cells(fine.grid);
    faces.end[at] += 1;
    for (int k = faces.begin[2]; k < faces.end[2]; ++k) {
      for (int j = faces.begin[1]; j < faces.end[1]; ++j) {
        for (int i = faces.begin[0]; i < faces.end[0]; ++i) {
          std::array<int, 3> place = {i, j, k};
          const double w = fine.weight[at][static_cast<std::size_t>(fine.grid.at(i, j, k))];
          const bool last = place[at] == fine.grid.cells[at];
          if (!last && place[at] % factor[at] != 0) continue;  // within a coarse cell
          for (std::size_t e = 0; e < 3; ++e) place[e] /= factor[e];
          if (last) place[at] = coarse.grid.cells[at];
          coarse.weight[at][static_cast<std::size_t>(coarse.grid.at(place[0], place[1], place[2]))] +=
              w / factor[at];
        }
      }
    }
  }
  coarse.set_diagonal();
}

}  // namespace samara::flow
