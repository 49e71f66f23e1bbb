// What the pressure and a step cost.
#include <cmath>
#include <stdexcept>
#include <string>

#include <tbb/task_arena.h>

#include "cases.h"
#ifdef SAMARA_BENCHMARK_HYPRE
#include "hypre_peer.h"
#endif
#include "samara/base/streams.h"
#include "samara/pgd/linear/sparse_solver.h"
#include "tests/flow/flow_cases.h"

namespace samara::benchmarks {

namespace {

using namespace flow_cases;

/// A plate in the middle of a stream, and a random source.
struct PressureProblem {
  PoissonMatrix matrix;
  Field source;

  explicit PressureProblem(const MacGrid& grid) : matrix(grid), source(grid.field()) {
    const Borders borders = stream();
    Shape shape = grid.dimensions == 3 ? box_shape({1.0, 0.25, 1.0}) : rectangle_section(1.0, 0.125);
    Eigen::Vector3d middle = 0.5 * Eigen::Vector3d(grid.length(0), grid.length(1), grid.length(2));
    if (grid.dimensions == 2) middle.z() = 0.0;
    const Openness open = measure_openness(grid, borders, PlacedShape(std::move(shape), middle, 1.5));
    matrix = pressure_matrix(grid, borders, open.face, open.inverse_volume);
    Stream random(3, 0);
    for (std::size_t c = 0; c < source.size(); ++c) {
      if (matrix.inverse_diagonal[c] > 0.0) source[c] = 2.0 * random.uniform() - 1.0;
    }
  }

  PressureSolve solve(PressureSolver& solver) const {
    Field b = source, x = matrix.grid.field();
    return solver.solve(b, x, 1e-8);
  }
};

#ifdef SAMARA_BENCHMARK_HYPRE
/// To the same largest residual, 1e-8. hypre runs on one process; ours on two threads, and on one.
void compare_with_hypre(const std::string& name, const PressureProblem& problem, double ours, int repeats) {
  HyprePoisson hypre(problem.matrix);
  double tolerance = 1e-8;
  int iterations = hypre.solve(problem.source, tolerance);
  while (hypre.largest_residual(problem.source) > 1e-8 && tolerance > 1e-13) {
    tolerance *= 0.5;
    iterations = hypre.solve(problem.source, tolerance);
  }
  if (!(hypre.largest_residual(problem.source) <= 1e-8))
    throw std::runtime_error("hypre does not solve the same equation");
  const double theirs = time_of([&] { hypre.solve(problem.source, tolerance); }, repeats);
  print({kFlow, name, "time", ours, "s", "hypre PCG and PFMG, one process", theirs / ours});
  double alone = 0.0;
  tbb::task_arena(1).execute([&] {
    const auto cycles = make_pressure_solver(PressureSolverKind::multigrid, problem.matrix);
    problem.solve(*cycles);
    alone = time_of([&] { problem.solve(*cycles); }, repeats);
  });
  print({kFlow, name, "time_one_thread", alone, "s", "hypre PCG and PFMG, one process", theirs / alone});
  print({kFlow, name, "iterations_hypre", static_cast<double>(iterations)});
}
#endif

void run_poisson(const std::string& name, const MacGrid& grid, const Options& options) {
  const PressureProblem problem(grid);
  const auto cycles = make_pressure_solver(PressureSolverKind::multigrid, problem.matrix);
  const int repeats = options.quick ? 3 : 9;
  print({kFlow, name, "iterations", static_cast<double>(problem.solve(*cycles).iterations)});
  const double ours = time_of([&] { problem.solve(*cycles); }, repeats);
  if (grid.dimensions == 3) {
#ifdef SAMARA_BENCHMARK_HYPRE
    return compare_with_hypre(name, problem, ours, repeats);
#else
    return print({kFlow, name, "time", ours, "s"});
#endif
  }
  const auto factors = make_pressure_solver(PressureSolverKind::direct, problem.matrix);
  const double theirs = time_of([&] { problem.solve(*factors); }, repeats);
  const bool cholmod = pgd::is_available(pgd::SparseSolverKind::cholmod);
  print({kFlow, name, "time", ours, "s",
         cholmod ? "cholmod, factorised before" : "eigen_ldlt, factorised before", theirs / ours});
}

void run_step() {
  Borders borders = stream();
  const std::array<double, 2> inflow = stream_turbulence(0.02, 1.0, 1.0);
  borders.side[0].k = inflow[0];
  borders.side[0].epsilon = inflow[1];
  FlowMarch march({.grid = MacGrid(2, {512, 256, 1}, 0.04, Eigen::Vector3d::Zero()),
                   .borders = borders,
                   .body = PlacedShape(rectangle_section(1.0, 0.125), {8.0, 5.12, 0.0}, 1.5),
                   .viscosity = 5e-5,
                   .turbulence = TurbulenceModel::k_epsilon});
  march.set_velocity([](const Eigen::Vector3d&) { return Eigen::Vector3d(1.0, 0.0, 0.0); });
  march.set_turbulence(inflow[0], inflow[1]);
  for (int s = 0; s < 20; ++s) march.advance();
  print({kFlow, "step_512x256", "time", time_of([&] { march.advance(); }, 30, 0.0), "s"});
}

}  // namespace

void run_costs(const Options& options) {
  tbb::task_arena(2).execute([&] {
    if (options.wants("poisson_512x256"))
      run_poisson("poisson_512x256", MacGrid(2, {512, 256, 1}, 0.04, Eigen::Vector3d::Zero()), options);
    if (options.wants("poisson_96"))
      run_poisson("poisson_96", MacGrid(3, {96, 96, 96}, 1.0 / 12, Eigen::Vector3d::Zero()), options);
    if (options.wants("step_512x256")) run_step();
  });
}

}  // namespace samara::benchmarks
