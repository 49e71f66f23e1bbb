// (6.22), u1' = 1 - u2 u3 and so on, over its initial values in [0, 1]^3.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cases.h"
#include "problems.h"
#include "samara/models/batch/batch.h"
#include "samara/pgd/evolution/slab_evolution.h"
#include "samara/pgd/nonlinear/strategy_trial.h"

namespace samara::benchmarks {

namespace {

using namespace pgd;
using Clock = std::chrono::steady_clock;

constexpr double kEnd = 0.8;
constexpr int kSlabs = 8;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// On a fixed grid: slabs and nodes are given.
StrategyTrial decoupled(const Problem& problem, int nodes, double tolerance) {
  return try_strategy(problem.on(kSlabs, 6, nodes), *decoupling_strategy(), {.tolerance = tolerance});
}

/// Time of the full grid of initial values by the batch runner, at steps that meet 1e-6 (found by halving) at
/// the same times that a field answers at. In batches: the states of a grid of 160^3 do not fit in memory.
double sweep(const Problem& problem, int nodes) {
  constexpr double kStep = 0.02;
  constexpr Eigen::Index kBatch = 100'000;
  std::vector<double> times;
  for (int i = 1; i <= kSlabs; ++i) times.push_back(kEnd * i / kSlabs);
  const Eigen::VectorXd grid = Eigen::VectorXd::LinSpaced(nodes, 0.0, 1.0);
  const Eigen::Index all = Eigen::Index{nodes} * nodes * nodes;
  const Clock::time_point begin = Clock::now();
  for (Eigen::Index first = 0; first < all; first += kBatch) {
    Eigen::MatrixXd points(std::min(kBatch, all - first), 3);
    for (Eigen::Index j = 0; j < points.rows(); ++j) {
      Eigen::Index index = first + j;
      for (int k = 0; k < 3; ++k) {
        points(j, k) = grid[index % nodes];
        index /= nodes;
      }
    }
    (void)models::integrate_batch(*problem.model, points, times, {.step = kStep});
  }
  return seconds_since(begin);
}

void run_decoupling(const Options& options) {
  const Problem problem = triple_product(kEnd);
  const std::string name = "triple_product";
  const StrategyTrial result = decoupled(problem, 20, 2e-7);
  double error = HUGE_VAL;
  if (result.status == samara::Termination::converged) {
    const auto value = [&](std::span<const double> x) { return result.value_at(x); };
    error = errors_of(problem, value, kEnd, options.quick ? 100 : 500).largest.maxCoeff();
  }
  print({kNonlinear, name, "error_max", error});
  print({kNonlinear, name, "iterations", static_cast<double>(result.largest_iterations())});
  print({kNonlinear, name, "contraction", result.largest_contraction()});
  print({kNonlinear, name, "rank", static_cast<double>(result.largest_rank())});
  print({kNonlinear, name, "time", result.seconds, "s"});
  for (const int nodes : {5, 20, 80, 160}) {
    const double swept = sweep(problem, nodes);
    for (const double tolerance : {2e-7, 2e-4}) {
      if (options.quick && nodes > 80) continue;
      const double ours = decoupled(problem, nodes, tolerance).seconds;
      const char* const suffix = tolerance < 1e-6 ? "" : "_at_1e-3";
      print({kNonlinear, name, fmt::format("time_{}{}", nodes, suffix), ours, "s", "sweep", swept / ours});
    }
  }
}

/// On t in [0, 1] the solution does not exist everywhere: from (0, 1, 1) it blows up at t = 0.953.
void run_blowup() {
  constexpr const char* kName = "triple_product_blowup";
  const Problem problem = triple_product(1.0);
  const EvolutionProblem grid = problem.on(1, 2, 2);
  AdaptiveProblem adaptive;
  adaptive.system = problem.system.get();
  adaptive.time = {"t", "1", AxisRole::time};
  adaptive.end = 1.0;
  for (const Interval& interval : problem.box)
    adaptive.parameters.push_back({{interval.name, "1", AxisRole::initial}, interval.lower, interval.upper});
  adaptive.states = grid.states;
  adaptive.scales = grid.scales;
  adaptive.scale_floors = {0.0, 0.0, 0.0};
  adaptive.initial = grid.initial;
  const SlabResult result = solve_by_slabs(adaptive, {.tolerance = 1e-3, .max_cells = 64});
  print({kNonlinear, kName, "ceases", result.status == samara::Termination::ceases ? 1.0 : 0.0});
  print({kNonlinear, kName, "reported_time", result.reached});
  const std::array names = {"reported_u1", "reported_u2", "reported_u3"};
  for (std::size_t k = 0; k < std::min(names.size(), result.where.size()); ++k)
    print({kNonlinear, kName, names[k], result.where[k]});
  print({kNonlinear, kName, "time", result.seconds, "s"});
}

}  // namespace

void run_products(const Options& options) {
  if (options.wants("triple_product")) run_decoupling(options);
  if (options.wants("triple_product_blowup")) run_blowup();
}

}  // namespace samara::benchmarks
