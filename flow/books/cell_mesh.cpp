#include "samara/flow/books/cell_mesh.h"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/SparseCore>

namespace samara::flow {

namespace {

/// visit(i, j, k) for all cells in their order.
template <class Visit>
void for_cells(const MacGrid& grid, const Visit& visit) {
  for (int k = 0; k < grid.cells[2]; ++k) {
    for (int j = 0; j < grid.cells[1]; ++j) {
      for (int i = 0; i < grid.cells[0]; ++i) visit(i, j, k);
    }
  }
}

/// The square between four centres is two triangles, the cube between eight six tetrahedra about one diagonal (Kuhn):
/// those of neighbours meet.
std::vector<std::vector<std::array<int, 3>>> simplices(int dimensions) {
  if (dimensions == 2) return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  std::vector<std::vector<std::array<int, 3>>> all;
  for (const std::array<int, 3>& order :
       {std::array{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}) {
    std::vector<std::array<int, 3>> corners = {{0, 0, 0}};
    for (const int direction : order) {
      corners.push_back(corners.back());
      corners.back()[static_cast<std::size_t>(direction)] = 1;
    }
    all.push_back(std::move(corners));
  }
  return all;
}

}  // namespace

codebooks::SpaceMesh cell_mesh(const MacGrid& grid) {
  const int d = grid.dimensions;
  Eigen::MatrixXd points(d, grid.cell_count());
  Eigen::Index node = 0;
  for_cells(grid, [&](int i, int j, int k) { points.col(node++) = grid.centre(i, j, k).head(d); });
  const auto parts = simplices(d);
  Eigen::Index cubes = 1;
  for (int direction = 0; direction < d; ++direction)
    cubes *= grid.cells[static_cast<std::size_t>(direction)] - 1;
  Eigen::MatrixXi cells(d + 1, cubes * std::ssize(parts));
  const auto number = [&](int i, int j, int k) { return i + grid.cells[0] * (j + grid.cells[1] * k); };
  Eigen::Index next = 0;
  for_cells(grid, [&](int i, int j, int k) {
    if (i + 1 == grid.cells[0] || j + 1 == grid.cells[1] || (d == 3 && k + 1 == grid.cells[2])) return;
    for (const auto& corners : parts) {
      for (std::size_t c = 0; c < corners.size(); ++c)
        cells(static_cast<Eigen::Index>(c), next) =
            number(i + corners[c][0], j + corners[c][1], k + corners[c][2]);
      ++next;
    }
  });
  std::vector<std::string> directions = {"x", "y"};
  if (d == 3) directions.emplace_back("z");
  return {std::move(directions), "1", std::move(points), std::move(cells)};
}

pgd::Axis cell_axis(const MacGrid& grid) {
  const Eigen::Index nodes = grid.cell_count();
  Eigen::SparseMatrix<double> mass(nodes, nodes);
  mass.setIdentity();
  mass *= std::pow(grid.spacing, grid.dimensions);
  return pgd::Axis::imported({"node", "1", pgd::AxisRole::space}, mass);
}

Eigen::VectorXd cells_in_order(const MacGrid& grid, const Field& field) {
  Eigen::VectorXd values(grid.cell_count());
  Eigen::Index node = 0;
  for_cells(grid,
            [&](int i, int j, int k) { values[node++] = field[static_cast<std::size_t>(grid.at(i, j, k))]; });
  return values;
}

Field field_in_order(const MacGrid& grid, const Eigen::VectorXd& values) {
  Field field = grid.field();
  Eigen::Index node = 0;
  for_cells(grid,
            [&](int i, int j, int k) { field[static_cast<std::size_t>(grid.at(i, j, k))] = values[node++]; });
  return field;
}

void continue_into_body(const MacGrid& grid, const Openness& body, Field& field) {
  // Margins of the grid count as closed for good: they hold no values.
  std::vector<char> known(field.size(), 0);
  std::vector<Index> closed;
  for_cells(grid, [&](int i, int j, int k) {
    const Index c = grid.at(i, j, k);
    const auto at = static_cast<std::size_t>(c);
    known[at] = body.inverse_cell[at] > 0.0 ? 1 : 0;
    if (known[at] == 0) closed.push_back(c);
  });
  while (!closed.empty()) {
    std::vector<Index> left;
    std::vector<std::pair<std::size_t, double>> layer;
    for (const Index c : closed) {
      double sum = 0.0;
      int count = 0;
      for (int d = 0; d < grid.dimensions; ++d) {
        for (const Index neighbour :
             {c - grid.stride[static_cast<std::size_t>(d)], c + grid.stride[static_cast<std::size_t>(d)]}) {
          const auto n = static_cast<std::size_t>(neighbour);
          if (known[n] == 0) continue;
          sum += field[n];
          ++count;
        }
      }
      if (count == 0) {
        left.push_back(c);
      } else {
        layer.emplace_back(static_cast<std::size_t>(c), sum / count);
      }
    }
    if (layer.empty()) return;  // nothing is open
    for (const auto& [c, value] : layer) {
      field[c] = value;
      known[c] = 1;
    }
    closed = std::move(left);
  }
}

Field open_cells(const FlowCase& flow, const MacGrid& grid) {
  Borders borders;
  borders.side[0].kind = BorderKind::inflow;
  borders.side[1].kind = BorderKind::outflow;
  return measure_openness(grid, borders,
                          PlacedShape(flow.shape, Eigen::Vector3d::Zero(), flow.angle_of_attack))
      .cell;
}

}  // namespace samara::flow
