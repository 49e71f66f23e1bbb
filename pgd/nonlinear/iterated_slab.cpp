#include "samara/pgd/nonlinear/iterated_slab.h"

#include <utility>
#include <vector>

#include "samara/pgd/evolution/march_context.h"
#include "samara/pgd/nonlinear/slab_iteration.h"

namespace samara::pgd {

namespace {

/// Of what a slab may add to the error; time, nodes and rounding have the rest.
constexpr double kStrategyShare = 0.4;
/// Elements of the time along which strategies are trained before the march.
constexpr int kTrainingElements = 10;

EvolutionProblem problem_on(const AdaptiveProblem& problem, Axis time, std::vector<Axis> axes,
                            const std::vector<double>& scales) {
  return {problem.system, std::move(time), std::move(axes), problem.states, scales, problem.initial};
}

}  // namespace

std::optional<Ending> IteratedSlab::prepare(const AdaptiveProblem& problem, const SlabOptions& options) {
  std::vector<Axis> axes;
  for (const AdaptiveAxis& axis : problem.parameters)
    axes.push_back(make_axis(axis, axis.nodes.value_or(options.first_nodes)));
  const Axis time = Axis::radau(problem.time, 0.0, problem.end, kTrainingElements, MarchContext::kTimePoints);
  return strategy_.prepare(problem_on(problem, time, std::move(axes), problem.scales),
                           0.1 * kStrategyShare * options.tolerance);
}

Outcome<SolvedSlab> IteratedSlab::solve(MarchContext& context, SlabCell& cell, Random& random) {
  const Axis time =
      Axis::radau(context.problem().time, cell.time, cell.slab->end(), 1, MarchContext::kTimePoints);
  const EvolutionProblem problem =
      problem_on(context.problem(), time, cell.axes, {context.scales().begin(), context.scales().end()});
  const double tolerance = kStrategyShare * cell.strictness * cell.leniency * context.tolerance();
  StrategyCounts counts;
  const StrategySlab slab(problem, 0, cell.start, tolerance, context.options().max_rank, random, counts);
  SlabIteration iteration(slab, {.progress = [&](const Progress&) { return !context.is_cancelled(); }},
                          counts);
  const std::optional<Ending> failure = iteration.run(strategy_);
  context.count(counts.rhs + counts.jacobian);
  if (failure) return *failure;
  const IterationRecord& record = iteration.record();
  const int derivatives = record.jacobian_ranks.empty() ? 0 : 1;  // J counts as f does
  double on_grid = static_cast<double>(slab.points()) * record.iterations * (1 + derivatives);
  for (const int size : slab.sizes()) on_grid *= size;
  return SolvedSlab{iteration.iterate(), record.contraction, static_cast<double>(record.iterations), on_grid};
}

}  // namespace samara::pgd
