#include "samara/codebooks/build/pgd_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/build/strategy_builder.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/codebooks/source/model_system.h"
#include "samara/pgd/evolution/adaptive_evolution.h"
#include "samara/pgd/evolution/slab_evolution.h"

namespace samara::codebooks {

namespace {

std::vector<double> box_centre(const Plan& plan) {
  std::vector<double> centre;
  for (const BoxEntry& entry : plan.box) centre.push_back(0.5 * (entry.lower + entry.upper));
  return centre;
}

pgd::AdaptiveProblem problem_of(const Plan& plan, const models::ParametricModel& model,
                                const ModelSystem& system) {
  const models::ModelInfo& info = model.model().info();
  const models::Scales scales = model.scales(box_centre(plan));
  pgd::AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", models::time_unit(info), pgd::AxisRole::time};
  problem.end = plan.end;
  std::vector<double> start(info.states.size());
  model.initial(box_centre(plan), start);
  for (std::size_t s = 0; s < info.states.size(); ++s) {
    problem.states.push_back({info.states[s].name, info.states[s].unit});
    problem.scales.push_back(models::state_scale(info.states[s], scales));
    const auto floor = plan.absolute.find(info.states[s].name);
    problem.scale_floors.push_back(floor == plan.absolute.end() ? 0.0 : floor->second);
    problem.initial.push_back({start[s], -1});
  }
  for (std::size_t k = 0; k < plan.box.size(); ++k) {
    const models::FreeCoordinate& free = model.free()[k];
    const pgd::AxisRole role = free.is_initial ? pgd::AxisRole::initial : pgd::AxisRole::parameter;
    const BoxEntry& entry = plan.box[k];
    problem.parameters.push_back(
        {{free.name, free.unit, role, entry.transform}, entry.lower, entry.upper, entry.nodes, entry.basis});
    if (!free.is_initial) continue;
    const auto state = static_cast<std::size_t>(free.index);
    problem.initial[state].axis = static_cast<int>(k);
    problem.scales[state] =
        std::max({problem.scales[state], std::abs(plan.box[k].lower), std::abs(plan.box[k].upper)});
  }
  return problem;
}

BuildRecord record_of(const pgd::AdaptiveResult& result) {
  BuildRecord record;
  record.builder = "pgd";
  record.strategy = "newton";
  record.status = result.status == pgd::AdaptiveStatus::converged         ? Termination::converged
                  : result.status == pgd::AdaptiveStatus::not_resolved    ? Termination::not_resolved
                  : result.status == pgd::AdaptiveStatus::max_evaluations ? Termination::max_calls
                                                                          : result.evolution.status;
  record.message = result.message;
  record.evaluations = static_cast<double>(result.state.rhs_evaluations + result.state.jacobian_evaluations);
  record.grid_size = result.evolution.grid_size;
  record.iterations = result.state.iterations;
  record.rounds = result.state.round;
  return record;
}

BuildRecord record_of(const pgd::SlabResult& result) {
  BuildRecord record;
  record.builder = "pgd";
  record.strategy = "slabs";
  record.status = result.status;
  record.message = result.message;
  record.evaluations = static_cast<double>(result.evaluations);
  record.grid_size = result.grid_evaluations;
  record.iterations = 0;
  record.rounds = result.marches;
  return record;
}

/// Stores the solver's state. A disk that is full must not end a build that needs no disk: it is told once.
template <class State>
std::function<void(const State&)> checkpoint_writer(const Plan& plan, const BuildOptions& options,
                                                    void (*save)(const std::filesystem::path&,
                                                                 const std::string&, const State&)) {
  if (options.checkpoint.empty()) return {};
  return [&plan, &options, save, warned = false](const State& state) mutable {
    try {
      save(options.checkpoint, plan.text, state);
    } catch (const ArgumentError& error) {
      if (!warned && options.warning) options.warning(fmt::format("no checkpoint: {}", error.what()));
      warned = true;
    }
  };
}

/// A checkpoint of this plan's text that has other axes or states than the plan is no checkpoint of it.
void check_fits(const pgd::AdaptiveProblem& problem, const pgd::SolverState& state,
                const std::filesystem::path& checkpoint) {
  if (state.round == 0) return;
  bool fits = state.nodes.size() == problem.parameters.size() && state.scales.size() == problem.states.size();
  for (std::size_t k = 0; fits && k < state.nodes.size(); ++k) {
    const pgd::AdaptiveAxis& planned = problem.parameters[k];
    const pgd::Axis& axis = state.field->axes()[k + 1];
    fits = axis.name() == planned.label.name && axis.lower() == planned.lower &&
           axis.upper() == planned.upper &&
           state.nodes[k] <= planned.nodes.value_or(pgd::AdaptiveOptions().max_nodes);
  }
  if (fits && state.time_elements <= pgd::AdaptiveOptions().max_time_elements &&
      state.round < pgd::AdaptiveOptions().max_rounds + 1)
    return;
  throw bad_checkpoint(checkpoint, "axes, nodes, states or rounds of the checkpoint do not fit the plan");
}

/// @throws InputError if a checkpoint that is to be taken up is not of this plan
pgd::SlabResult slab_result(const pgd::AdaptiveProblem& problem, const pgd::SlabOptions& slabs,
                            const Plan& plan, const BuildOptions& options) {
  if (!options.resume || !is_checkpoint(options.checkpoint)) return pgd::solve_by_slabs(problem, slabs);
  const std::vector<double> state = load_march(options.checkpoint, plan.text);
  try {
    return pgd::solve_by_slabs(problem, slabs, state);
  } catch (const ArgumentError& error) {
    throw bad_checkpoint(options.checkpoint, error.what());
  }
}

Solution solve_by_slabs(const Plan& plan, const pgd::AdaptiveProblem& problem, const BuildOptions& options,
                        long max_evaluations, const ProgressCallback& progress) {
  pgd::SlabOptions slabs;
  slabs.tolerance = plan.relative;
  slabs.max_evaluations = max_evaluations;
  slabs.max_cells = plan.builder.max_cells;
  slabs.seed = plan.builder.seed;
  slabs.progress = progress;
  slabs.checkpoint = checkpoint_writer<std::vector<double>>(plan, options, save_march);
  pgd::SlabResult result = slab_result(problem, slabs, plan, options);
  if (result.pieces.empty()) {
    throw NoResultError(
        fmt::format("the march in slabs has no result on the first slab: {}", result.message));
  }
  Solution solution;
  for (pgd::TrainField& field : result.pieces) solution.pieces.push_back(Piece{{std::move(field)}});
  solution.record = record_of(result);
  solution.spent.nonlinearity = result.error;
  return solution;
}

[[noreturn]] void cannot_solve(const std::string& reason) {
  throw NoResultError(fmt::format("the separated engine cannot solve this plan, sampling may: {}", reason));
}

/// The plan was checked before: what the engine refuses now is a field that it cannot hold. One that it could
/// not even begin with is no result.
pgd::AdaptiveResult adaptive_result(const pgd::AdaptiveProblem& problem, const pgd::AdaptiveOptions& options,
                                    pgd::SolverState start) {
  try {
    pgd::AdaptiveResult result = solve_adaptively(problem, options, std::move(start));
    if (result.evolution.status == Termination::rank_limit && result.state.iterations == 0)
      cannot_solve(result.message);
    return result;
  } catch (const ArgumentError& error) {
    cannot_solve(error.what());
  }
}

/// Of a plan that sets no limit: some hundred times what a coin to 1e-5 takes.
constexpr long kMostNewtonEvaluations = 20'000'000;

Solution solve_by_newton(const Plan& plan, const pgd::AdaptiveProblem& problem, const BuildOptions& options,
                         long max_evaluations, const ProgressCallback& progress) {
  pgd::AdaptiveOptions adaptive;
  adaptive.tolerance = plan.relative;
  adaptive.max_evaluations = max_evaluations > 0 ? max_evaluations : kMostNewtonEvaluations;
  adaptive.evolution.seed = plan.builder.seed;
  adaptive.evolution.progress = progress;
  adaptive.checkpoint = checkpoint_writer<pgd::SolverState>(plan, options, save_checkpoint);
  pgd::SolverState start;
  if (options.resume && is_checkpoint(options.checkpoint))
    start = load_checkpoint(options.checkpoint, plan.text);
  check_fits(problem, start, options.checkpoint);
  pgd::AdaptiveResult result = adaptive_result(problem, adaptive, std::move(start));
  Solution solution;
  solution.pieces.push_back(Piece{{std::move(result.evolution.field)}});
  solution.record = record_of(result);
  solution.residual = result.evolution.residual;
  for (const pgd::AxisResolution& axis : result.resolution) {
    solution.spent.discretisation = std::max(solution.spent.discretisation, axis.coefficients);
  }
  solution.spent.compression = result.evolution.residual;
  solution.spent.nonlinearity = result.evolution.nonlinearity_error;
  return solution;
}

/// Slabs choose nodes by themselves and refine what they are given badly; a grid that the plan prescribes is
/// taken as it is by the solver of the whole time.
bool is_for_slabs(const Plan& plan) {
  return plan.builder.strategy == "slabs" || (plan.builder.strategy == "auto" && !plan.prescribes_axes());
}

}  // namespace

Solution solve_by_pgd(const Plan& plan, const models::ParametricModel& model, const BuildOptions& options,
                      long max_evaluations, const ProgressCallback& progress) {
  const ModelSystem system(model);
  const pgd::AdaptiveProblem problem = problem_of(plan, model, system);
  const auto solve = is_marched(plan.builder.strategy) ? solve_by_strategy
                     : is_for_slabs(plan)              ? solve_by_slabs
                                                       : solve_by_newton;
  return solve(plan, problem, options, max_evaluations, progress);
}

}  // namespace samara::codebooks
