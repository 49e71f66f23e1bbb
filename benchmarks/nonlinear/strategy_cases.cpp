// Six strategies on five problems: what meets its tolerance, and what fails, stands as it is.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cases.h"
#include "problems.h"
#include "samara/pgd/nonlinear/strategy_trial.h"

namespace samara::benchmarks {

namespace {

using namespace pgd;

struct StrategyProblem {
  const char* name;
  Problem problem;
  int slabs, nodes;
  double tolerance = 1e-6;  ///< of the whole, over the ranges; a slab gets a tenth
};

std::vector<std::pair<std::string, std::unique_ptr<Strategy>>> strategies() {
  std::vector<std::pair<std::string, std::unique_ptr<Strategy>>> all;
  all.emplace_back("incremental", incremental_strategy());
  all.emplace_back("polynomial", polynomial_strategy());
  all.emplace_back("asymptotic", asymptotic_strategy());
  all.emplace_back("empirical", empirical_strategy());
  all.emplace_back("piecewise_linear", piecewise_linear_strategy({.weight_tolerance = 2e-2}));
  all.emplace_back("cross", cross_strategy());
  return all;
}

/// Seconds after which a march is cancelled: what takes longer has failed.
constexpr double kPatience = 60.0;

void run(const StrategyProblem& at, Strategy& strategy, const std::string& name, int points) {
  const std::string test_case = fmt::format("strategies_{}", at.name);
  const EvolutionProblem problem = at.problem.on(at.slabs, 8, at.nodes);
  StrategyTrialOptions options{.tolerance = 0.1 * at.tolerance, .max_evaluations = 50'000'000};
  // It is wrong by about a per cent by nature, and its weights have no separated form to much less.
  if (name == "piecewise_linear") {
    options.tolerance = 5e-3;
    options.max_rank = 250;
  }
  const auto begin = std::chrono::steady_clock::now();
  options.progress = [&](const Progress&) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < kPatience;
  };
  const StrategyTrial result = try_strategy(problem, strategy, options);
  print({kNonlinear, test_case, name + "_time", result.seconds, "s"});
  print({kNonlinear, test_case, name + "_reached", result.reached});
  const auto value = [&](std::span<const double> x) { return result.value_at(x); };
  const double error = result.pieces.empty()
                           ? std::nan("")
                           : errors_of(at.problem, value, result.reached, points).largest.maxCoeff();
  // What converges to other equations, or with too few nodes, has missed.
  const bool missed = result.status == samara::Termination::converged && !(error <= at.tolerance);
  // The status by its number and, as the unit, its word.
  print({kNonlinear, test_case, name + "_status", static_cast<double>(result.status),
         missed ? "missed" : to_string(result.status)});
  if (result.pieces.empty()) return;
  print({kNonlinear, test_case, name + "_error", error});
  print({kNonlinear, test_case, name + "_rank", static_cast<double>(result.largest_rank())});
  print({kNonlinear, test_case, name + "_iterations", static_cast<double>(result.largest_iterations())});
}

}  // namespace

void run_strategies(const Options& options) {
  std::vector<StrategyProblem> problems;
  problems.push_back({"quadratic_drag", quadratic_drag(1.0), 10, 16});
  problems.push_back({"triple_product", triple_product(0.8), 10, 14});
  problems.push_back({"plate3_t2", plate3(2.0), 10, 12});
  problems.push_back({"plate3_t5", plate3(5.0), 25, 18, 1e-4});
  problems.push_back({"kirchhoff", kirchhoff(0.2), 4, 8, 1e-2});
  for (const StrategyProblem& problem : problems) {
    if (!options.wants(fmt::format("strategies_{}", problem.name))) continue;
    for (const auto& [name, strategy] : strategies()) run(problem, *strategy, name, options.quick ? 50 : 300);
  }
}

}  // namespace samara::benchmarks
