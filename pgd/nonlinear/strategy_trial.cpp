#include "samara/pgd/nonlinear/strategy_trial.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <initializer_list>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/slab_train.h"
#include "samara/pgd/nonlinear/slab_iteration.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kDefectPoints = 32;
/// Of the strategy that gives the first iterate.
constexpr int kFirstIterations = 2;

TrainField field(const StrategySlab& slab, const TensorTrain& solution) {
  const EvolutionProblem& problem = slab.problem();
  const Axis time = Axis::radau({problem.time.name(), problem.time.unit(), AxisRole::time}, slab.begin(),
                                slab.begin() + slab.length(), 1, slab.points());
  return slab_field(time, problem.parameters, problem.states, slab.scales(), solution);
}

TensorTrain end_of(const StrategySlab& slab, const TensorTrain& solution) {
  return slab.compressed(last_rows(solution, slab.states()), 0.1 * slab.tolerance());
}

/// At random points of the box: what too few nodes leave is in it.
double defect_off_grid(const StrategySlab& slab, const TensorTrain& solution) {
  const std::vector<Axis>& axes = slab.problem().parameters;
  const Eigen::MatrixXd q = random_points(axes, kDefectPoints, slab.random());
  return defect_at(slab, q, values_at(solution, axes, q));
}

void validate(const EvolutionProblem& problem, const StrategyTrialOptions& options) {
  problem.validate();
  if (problem.time.basis() != Basis::radau || problem.parameters.empty()) {
    throw ArgumentError(
        fmt::format("a problem with {} parameter axes and a time axis of the kind {}; expected at least one "
                    "parameter and radau, whose elements are the slabs",
                    problem.parameters.size(), to_string(problem.time.basis())));
  }
  constexpr const char* kWhere = "StrategyTrialOptions";
  require(options.tolerance > 0.0, "tolerance", options.tolerance, "a positive number", kWhere);
  require(options.max_iterations >= 1, "max_iterations", options.max_iterations, "1 or more", kWhere);
  require(options.max_rank >= 1, "max_rank", options.max_rank, "1 or more", kWhere);
  require(options.max_evaluations >= 0, "max_evaluations", options.max_evaluations, "0 or more", kWhere);
}

double grid_evaluations(const StrategySlab& slab, int iterations) {
  double result = static_cast<double>(slab.points()) * iterations;
  for (const int size : slab.sizes()) result *= size;
  return result;
}

void take(const Ending& ending, StrategyTrial& result) {
  result.status = ending.status;
  result.message = ending.message;
  result.where = ending.where;
}

void take(const IterationRecord& done, StrategyRecord& record) {
  record.iterations = done.iterations;
  record.corrections = done.corrections;
  record.contraction = done.contraction;
  record.source_ranks = done.source_ranks;
  record.jacobian_ranks = done.jacobian_ranks;
}

/// One slab; the state at its end becomes the start of the next.
void advance(const StrategySlab& slab, Strategy& strategy, const StrategyTrialOptions& options,
             const StrategyCounts& counts, TensorTrain& start, StrategyRecord& record,
             StrategyTrial& result) {
  SlabIteration iteration(slab,
                          {.max_iterations = options.max_iterations,
                           .max_evaluations = options.max_evaluations,
                           .evaluations_before = result.rhs_evaluations + result.jacobian_evaluations,
                           .progress = options.progress},
                          counts);
  if (options.first != nullptr) iteration.first_iterate(*options.first, kFirstIterations);
  const std::optional<Ending> failure = iteration.run(strategy);
  take(iteration.record(), record);
  record.detail = strategy.detail();
  record.ranks = iteration.iterate().ranks();
  record.status = failure ? failure->status : Termination::converged;
  if (failure) return take(*failure, result);
  record.defect = defect_off_grid(slab, iteration.iterate());
  result.pieces.push_back(field(slab, iteration.iterate()));
  result.reached = record.end;
  start = end_of(slab, iteration.iterate());
}

/// @returns false if a strategy fails already here, the result saying why
bool prepare(const EvolutionProblem& problem, std::initializer_list<Strategy*> strategies, double tolerance,
             StrategyTrial& result) {
  result.reached = problem.time.lower();
  for (Strategy* strategy : strategies) {
    if (strategy == nullptr) continue;
    const std::optional<Ending> failure = strategy->prepare(problem, tolerance);
    result.rhs_evaluations += strategy->prepared().rhs;
    result.jacobian_evaluations += strategy->prepared().jacobian;
    if (!failure) continue;
    take(*failure, result);
    return false;
  }
  return true;
}

}  // namespace

StrategyTrial try_strategy(const EvolutionProblem& problem, Strategy& strategy,
                           const StrategyTrialOptions& options) {
  validate(problem, options);
  const Clock::time_point begin = Clock::now();
  StrategyTrial result;
  if (!prepare(problem, {options.first, &strategy}, options.tolerance, result)) return result;
  Random random(options.seed);
  TensorTrain start =
      initial_train(problem.initial,
                    Eigen::Map<const Eigen::VectorXd>(problem.scales.data(),
                                                      static_cast<Eigen::Index>(problem.scales.size())),
                    problem.parameters);
  result.status = Termination::converged;
  for (int number = 0; number < problem.time.elements(); ++number) {
    const Clock::time_point slab_begin = Clock::now();
    StrategyCounts counts;
    const StrategySlab slab(problem, number, start, options.tolerance, options.max_rank, random, counts);
    StrategyRecord record{.begin = slab.begin(), .end = slab.begin() + slab.length()};
    advance(slab, strategy, options, counts, start, record, result);
    record.rhs_evaluations = counts.rhs;
    record.jacobian_evaluations = counts.jacobian;
    record.grid_evaluations = grid_evaluations(slab, record.iterations);
    record.seconds = std::chrono::duration<double>(Clock::now() - slab_begin).count();
    result.rhs_evaluations += counts.rhs;
    result.jacobian_evaluations += counts.jacobian;
    result.grid_evaluations += record.grid_evaluations;
    result.status = record.status;
    result.history.push_back(std::move(record));
    if (result.status != Termination::converged) break;
  }
  if (result.status == Termination::converged) {
    result.message = fmt::format("{} slabs, at most {} iterations, defect {:.3g} of the scales",
                                 result.history.size(), result.largest_iterations(), result.largest_defect());
  }
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

int StrategyTrial::largest_rank() const {
  int largest = 0;
  for (const StrategyRecord& record : history) {
    for (const int rank : record.ranks) largest = std::max(largest, rank);
  }
  return largest;
}

int StrategyTrial::largest_iterations() const {
  int largest = 0;
  for (const StrategyRecord& record : history) largest = std::max(largest, record.iterations);
  return largest;
}

double StrategyTrial::largest_contraction() const {
  double largest = 0.0;
  for (const StrategyRecord& record : history) largest = std::max(largest, record.contraction);
  return largest;
}

double StrategyTrial::largest_defect() const {
  double largest = 0.0;
  for (const StrategyRecord& record : history) largest = std::max(largest, record.defect);
  return largest;
}

Eigen::VectorXd StrategyTrial::value_at(std::span<const double> x) const {
  for (const TrainField& piece : pieces) {
    if (!x.empty() && piece.axes()[0].contains(x[0])) return piece(x);
  }
  throw ArgumentError(fmt::format("the time {} is outside what the march has covered, up to {}",
                                  x.empty() ? 0.0 : x[0], reached));
}

}  // namespace samara::pgd
