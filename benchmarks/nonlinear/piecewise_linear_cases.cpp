// PPWL of plate3 to t = 5, in separated form, with 20, 50 and 100 points picked along nine trajectories.
#include <algorithm>

#include <fmt/format.h>

#include "cases.h"
#include "problems.h"
#include "samara/pgd/nonlinear/strategy_trial.h"

namespace samara::benchmarks {

void run_piecewise_linear(const Options& options) {
  using namespace pgd;
  for (const int points : {20, 50, 100}) {
    const std::string name = fmt::format("ppwl_{}", points);
    if (!options.wants(name)) continue;
    const Problem problem = plate3(5.0);
    // What is approximated is wrong by per cents: neither weights nor solution deserve more.
    const EvolutionProblem grid = problem.on(20, 6, 10);
    const auto strategy = piecewise_linear_strategy({.points = points, .weight_tolerance = 2e-2});
    const StrategyTrial result = try_strategy(grid, *strategy, {.tolerance = 5e-3, .max_rank = 250});
    print({kNonlinear, name, "status", static_cast<double>(result.status), to_string(result.status)});
    if (result.pieces.empty()) continue;
    const auto value = [&](std::span<const double> x) { return result.value_at(x); };
    const Errors errors = errors_of(problem, value, result.reached, 200);
    int rank = 0;
    double error = 0.0;
    for (const StrategyRecord& record : result.history) {
      if (!record.detail) continue;
      rank = std::max(rank, record.detail->rank);
      error = std::max(error, record.detail->error);
    }
    print({kNonlinear, name, "error_vx", errors.relative_rms[0]});
    print({kNonlinear, name, "error_vy", errors.relative_rms[1]});
    print({kNonlinear, name, "error_omega", errors.relative_rms[2]});
    print({kNonlinear, name, "error_theta", errors.relative_rms[3]});
    print({kNonlinear, name, "rank", static_cast<double>(rank)});
    print({kNonlinear, name, "weights_error", error});
    print({kNonlinear, name, "solution_rank", static_cast<double>(result.largest_rank())});
    print({kNonlinear, name, "reached", result.reached});
    print({kNonlinear, name, "time", result.seconds, "s"});
  }
}

}  // namespace samara::benchmarks
