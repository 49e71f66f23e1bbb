#include "samara/pgd/nonlinear/march.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"
#include "samara/pgd/nonlinear/iterated_slab.h"

namespace samara::pgd {

namespace {

constexpr const char* kSlabs = "slabs";

using StrategyFactory = std::unique_ptr<Strategy> (*)();

const std::map<std::string, StrategyFactory>& strategy_factories() {
  static const std::map<std::string, StrategyFactory> all = {
      {"enrichment", [] { return enrichment_strategy(); }},
      {"decoupling", [] { return decoupling_strategy(); }},
      {"incremental", [] { return incremental_strategy(); }},
      {"polynomial", [] { return polynomial_strategy(); }},
      {"asymptotic", [] { return asymptotic_strategy(); }},
      {"empirical", [] { return empirical_strategy(); }},
      {"piecewise_linear", [] { return piecewise_linear_strategy(); }},
      {"cross", [] { return cross_strategy(); }},
  };
  return all;
}

}  // namespace

const std::vector<std::string>& strategy_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = {kSlabs};
    for (const auto& [name, factory] : strategy_factories()) all.push_back(name);
    return all;
  }();
  return names;
}

std::unique_ptr<Strategy> strategy_named(const std::string& name) {
  const auto found = strategy_factories().find(name);
  if (found != strategy_factories().end()) return found->second();
  throw ArgumentError(
      fmt::format("the strategy is \"{}\", expected one of {}", name, fmt::join(strategy_names(), ", ")));
}

SlabResult march(const AdaptiveProblem& problem, const std::string& strategy, const SlabOptions& options,
                 std::span<const double> state) {
  if (strategy == kSlabs) return solve_by_slabs(problem, options, state);
  return march(problem, *strategy_named(strategy), options, state);
}

SlabResult march(const AdaptiveProblem& problem, Strategy& strategy, const SlabOptions& options,
                 std::span<const double> state) {
  check_march(problem, options);
  IteratedSlab solver(strategy);
  const std::optional<Ending> failure = solver.prepare(problem, options);
  const long prepared = strategy.prepared().rhs + strategy.prepared().jacobian;
  if (failure) {
    SlabResult result;
    result.evaluations = prepared;
    result.status = failure->status;
    result.message = failure->message;
    result.where = failure->where;
    return result;
  }
  SlabOptions rest = options;
  if (options.max_evaluations > 0) rest.max_evaluations = std::max(1L, options.max_evaluations - prepared);
  SlabResult result = solve_by_slabs(problem, solver, rest, state);
  result.evaluations += prepared;
  return result;
}

}  // namespace samara::pgd
