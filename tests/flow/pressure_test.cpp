#include <cmath>

#include <catch2/catch.hpp>
#include <tbb/task_arena.h>

#include "flow_cases.h"
#include "samara/base/streams.h"
#include "samara/flow/march/field_average.h"
#include "samara/flow/pressure/multigrid.h"

using namespace samara::flow;
using namespace flow_cases;

namespace {

/// A source that sums to 0, from a seed.
Field random_source(const PoissonMatrix& matrix) {
  samara::Stream stream(7, 0);
  Field b = matrix.grid.field();
  for (int k = 0; k < matrix.grid.cells[2]; ++k) {
    for (int j = 0; j < matrix.grid.cells[1]; ++j) {
      for (int i = 0; i < matrix.grid.cells[0]; ++i) {
        const auto c = static_cast<std::size_t>(matrix.grid.at(i, j, k));
        if (matrix.inverse_diagonal[c] > 0.0) b[c] = stream.normal();
      }
    }
  }
  return b;
}

PoissonMatrix plate_matrix(const MacGrid& grid, const Borders& borders) {
  Shape shape = grid.dimensions == 3 ? box_shape({1.0, 0.25, 1.0}) : rectangle_section(1.0, 0.25);
  const Eigen::Vector3d place =
      0.5 * Eigen::Vector3d(grid.length(0), grid.length(1), grid.dimensions == 3 ? grid.length(2) : 0);
  const Openness open = measure_openness(grid, borders, PlacedShape(std::move(shape), place, 1.1));
  return pressure_matrix(grid, borders, open.face, open.inverse_volume);
}

}  // namespace

TEST_CASE("multigrid and a direct factorisation give the same pressure about a body", "[flow]") {
  const MacGrid grid(2, {96, 57, 1}, 0.1, Eigen::Vector3d::Zero());
  const auto kinds = GENERATE(0, 1, 2);
  const Borders borders = kinds == 0 ? stream() : kinds == 1 ? Borders{} : all_periodic();
  const PoissonMatrix matrix = plate_matrix(grid, borders);
  Field b = random_source(matrix), x = grid.field(), y = grid.field();
  const PressureSolve by_cycles =
      make_pressure_solver(PressureSolverKind::multigrid, matrix)->solve(b, x, 1e-10);
  const PressureSolve by_factors =
      make_pressure_solver(PressureSolverKind::direct, matrix)->solve(b, y, 1e-10);
  INFO("iterations " << by_cycles.iterations);
  CHECK(by_cycles.converged);
  CHECK(by_factors.converged);
  double difference = 0.0;
  for (std::size_t c = 0; c < x.size(); ++c) {
    if (matrix.inverse_diagonal[c] > 0.0) difference = std::max(difference, std::abs(x[c] - y[c]));
  }
  CHECK(difference < 1e-8);
}

TEST_CASE("half-sweeps that go over the plane together have the numbers of one after the other", "[flow]") {
  // In a layer of cells in space they go one after the other, and nothing passes through its free sides.
  std::vector<Eigen::VectorXd> found;
  for (const int dimensions : {2, 3}) {
    const MacGrid grid(dimensions, {256, 128, 1}, 0.1, Eigen::Vector3d::Zero());
    const Borders borders = stream();
    const Openness open = measure_openness(grid, borders, {});
    const PoissonMatrix matrix = pressure_matrix(grid, borders, open.face, open.inverse_volume);
    Field b = random_source(matrix), x = grid.field();
    double largest = 0.0;
    for (const double value : b) largest = std::max(largest, std::abs(value));
    const PressureSolve one_cycle = MultigridSolver(matrix).solve(b, x, 0.9 * largest);
    CHECK(one_cycle.iterations == 1);
    Eigen::VectorXd& values = found.emplace_back(grid.cell_count());
    for (int j = 0; j < grid.cells[1]; ++j) {
      for (int i = 0; i < grid.cells[0]; ++i)
        values[i + Eigen::Index{grid.cells[0]} * j] = x[static_cast<std::size_t>(grid.at(i, j))];
    }
  }
  CHECK((found[0] - found[1]).cwiseAbs().maxCoeff() < 1e-12 * found[1].cwiseAbs().maxCoeff());
}

TEST_CASE("multigrid takes at most 15 iterations to 1e-8, in the plane and in space", "[flow]") {
  for (const bool space : {false, true}) {
    const MacGrid grid = space ? MacGrid(3, {32, 32, 32}, 0.125, Eigen::Vector3d::Zero())
                               : MacGrid(2, {256, 128, 1}, 0.05, Eigen::Vector3d::Zero());
    const PoissonMatrix matrix = plate_matrix(grid, stream());
    Field b = random_source(matrix), x = grid.field();
    double largest = 0.0;
    for (const double value : b) largest = std::max(largest, std::abs(value));
    const PressureSolve solve =
        make_pressure_solver(PressureSolverKind::multigrid, matrix)->solve(b, x, 1e-8 * largest);
    CHECK(solve.converged);
    CHECK(solve.iterations <= 15);
  }
}

TEST_CASE("one thread and two give the same bits of a flow, in the plane and in space", "[flow]") {
  const int dimensions = GENERATE(2, 3);
  // Rows enough that two threads share them.
  const std::array<int, 3> cells = dimensions == 2 ? std::array{160, 96, 1} : std::array{32, 20, 20};
  const double spacing = dimensions == 2 ? 0.0625 : 0.2;
  const Shape shape = dimensions == 2 ? rectangle_section(1.0, 0.25) : box_shape({1.0, 0.6, 1.0});
  const auto run = [&](int threads) {
    tbb::task_arena arena(threads);
    std::vector<Field> fields;
    arena.execute([&] {
      FlowMarch march({.grid = MacGrid(dimensions, cells, spacing, Eigen::Vector3d::Zero()),
                       .borders = stream(),
                       .body = PlacedShape(shape, {3.0, 2.0, 2.0}, 0.8),
                       .viscosity = 1e-4,
                       .turbulence = TurbulenceModel::k_epsilon});
      march.set_velocity([](const Eigen::Vector3d&) { return Eigen::Vector3d(1.0, 0.0, 0.0); });
      march.set_turbulence(6e-4, 3.4e-5);
      FieldAverage average(march.grid(), true);
      for (int s = 0; s < 12; ++s) average.add(march, march.advance().step);
      const FaceField mean = average.velocity();
      fields.assign(march.state().u.begin(), march.state().u.end());
      fields.insert(fields.end(), mean.begin(), mean.end());
      fields.insert(fields.end(), {march.state().p, march.turbulence()->k, march.turbulence()->epsilon,
                                   average.k_resolved()});
      const Eigen::Vector3d force = march.loads().force;
      fields.push_back(
          {force.x(), force.y(), force.z(), march.divergence(), march.turbulence()->total_production()});
    });
    return fields;
  };
  CHECK(run(1) == run(2));
}
