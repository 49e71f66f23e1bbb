// Every strategy on a case that suits it: the error it comes to, and the order at which it gets there. Orders
// are those of halving: the length of a slab, the tilt of the plate, or the distance between points.
#include <cmath>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "cases.h"
#include "problems.h"
#include "samara/pgd/nonlinear/strategy_trial.h"

namespace samara::benchmarks {

namespace {

using namespace pgd;

constexpr const char* kName = "strategy_orders";
constexpr double kTolerance = 1e-7;  ///< of a slab

double error_of(const Problem& problem, const StrategyTrial& result, int points) {
  if (result.status != samara::Termination::converged) return std::nan("");
  const auto value = [&](std::span<const double> x) { return result.value_at(x); };
  return errors_of(problem, value, problem.end, points).largest.maxCoeff();
}

void print_order(const std::string& strategy, double error, double order, double expected) {
  print({kNonlinear, kName, strategy + "_error", error});
  print({kNonlinear, kName, strategy + "_order", order});
  print({kNonlinear, kName, strategy + "_order_expected", expected});
}

/// A correction of the last slab falls with a power of its length: with the k-th for Picard's iteration,
/// whose k-th iterate has k right terms of Taylor's series in time; with the third already in the second
/// correction where the first iterate solves the equations linearised about the start.
void by_length(const char* name, Strategy& strategy, const Problem& problem, int slabs, int nodes,
               std::size_t correction, int points) {
  double corrections[2] = {}, error = 0.0;
  for (const int finer : {0, 1}) {
    const StrategyTrial result = try_strategy(problem.on(slabs << finer, 8, nodes), strategy,
                                              {.tolerance = finer == 0 ? kTolerance : 1e-2 * kTolerance});
    if (finer == 0) error = error_of(problem, result, points);
    const std::vector<double>& all = result.history.back().corrections;
    corrections[finer] = all.size() >= correction ? all[correction - 1] : std::nan("");
  }
  print_order(name, error, std::log2(corrections[0] / corrections[1]), 3.0);
}

/// Expanded to the second order about broadside fall, the plate errs by the cube of its tilt.
void by_tilt(const Options& options) {
  const auto strategy = polynomial_strategy({.state = broadside_fall()});
  double errors[2] = {};
  for (const int halved : {0, 1}) {
    const Problem problem = broadside_plate(halved == 0 ? 0.01 : 0.005, 1.0);
    const EvolutionProblem grid = problem.on(5, 8, 8);
    const StrategyTrial result = try_strategy(grid, *strategy, {.tolerance = 1e-9});
    const auto value = [&](std::span<const double> x) { return result.value_at(x); };
    const Eigen::VectorXd scales = Eigen::Map<const Eigen::VectorXd>(grid.scales.data(), 4);
    errors[halved] = result.status == samara::Termination::converged
                         ? errors_of(problem, value, problem.end, options.quick ? 30 : 100)
                               .absolute.cwiseQuotient(scales)
                               .maxCoeff()
                         : std::nan("");
  }
  print_order("polynomial", errors[1], std::log2(errors[0] / errors[1]), 3.0);
}

/// Between points a piecewise-linear f errs by the square of their distance.
void by_points(const Options& options) {
  const Problem problem = quadratic_drag(1.0);
  double errors[2] = {};
  for (const int finer : {0, 1}) {
    const auto strategy = piecewise_linear_strategy(
        {.points = finer == 0 ? 200 : 800, .samples = 16, .weight_tolerance = 1e-6});
    errors[finer] =
        error_of(problem, try_strategy(problem.on(10, 8, 16), *strategy, {.tolerance = kTolerance}),
                 options.quick ? 50 : 300);
  }
  print_order("piecewise_linear", errors[1], 0.5 * std::log2(errors[0] / errors[1]), 2.0);
}

}  // namespace

void run_strategy_orders(const Options& options) {
  if (!options.wants(kName)) return;
  const int points = options.quick ? 50 : 300;
  by_length("incremental", *incremental_strategy(), quadratic_drag(1.0), 10, 16, 3, points);
  by_tilt(options);
  by_length("asymptotic", *asymptotic_strategy(), quadratic_drag(1.0), 10, 16, 2, points);
  by_length("empirical", *empirical_strategy(), plate3(2.0), 10, 12, 3, points);
  by_points(options);
  by_length("cross", *cross_strategy(), plate3(2.0), 10, 12, 2, points);
}

}  // namespace samara::benchmarks
