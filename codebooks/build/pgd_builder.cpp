#include "samara/codebooks/build/pgd_builder.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/build/compaction.h"
#include "samara/codebooks/build/effort.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/codebooks/source/model_system.h"
#include "samara/pgd/nonlinear/march.h"
#include "samara/pgd/tensors/separation.h"
#include "samara/pgd/tensors/train_algebra.h"

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

/// The march that a plan asks for: "auto" leaves the choice to us, and "newton" linearises by Newton.
std::string strategy_of(const Plan& plan) {
  if (plan.builder.strategy == "auto") return "slabs";
  return plan.builder.strategy == "newton" ? "cross" : plan.builder.strategy;
}

BuildRecord record_of(const pgd::SlabResult& result, const std::string& strategy) {
  BuildRecord record;
  record.builder = "pgd";
  record.strategy = strategy;
  record.status = result.status;
  record.message = result.message;
  record.evaluations = static_cast<double>(result.evaluations);
  if (strategy != "slabs") {
    for (const pgd::SlabRecord& slab : result.history)
      record.iterations = std::max(record.iterations, static_cast<int>(slab.iterations));
  }
  record.rounds = result.marches;
  return record;
}

std::function<void(const std::vector<double>&)> checkpoint_writer(const Plan& plan,
                                                                  const BuildOptions& options) {
  if (options.checkpoint.empty()) return {};
  return told_once<std::vector<double>>(
      [checkpoint = Checkpoint(options.checkpoint, plan.whole_text())](
          const std::vector<double>& state) mutable { checkpoint.save_march(state); },
      options.warning);
}

/// @throws InputError if a checkpoint that is to be taken up is not of this plan
pgd::SlabResult marched(const pgd::AdaptiveProblem& problem, const std::string& strategy,
                        const pgd::SlabOptions& slabs, const Plan& plan, const BuildOptions& options) {
  if (!options.resume || !is_checkpoint(options.checkpoint)) return pgd::march(problem, strategy, slabs);
  const std::vector<double> state = Checkpoint(options.checkpoint, plan.whole_text()).march();
  try {
    return pgd::march(problem, strategy, slabs, state);
  } catch (const ArgumentError& error) {
    throw bad_checkpoint(options.checkpoint, error.what());
  }
}

/// Of the tolerance, what a train may lose when it becomes a sum of products.
constexpr double kShareOfSum = 0.1;
/// Of what the march left of the tolerance, what may be spent on joining slabs before that.
constexpr double kShareOfJoining = 0.3;

/// The field as a sum of products, as enrichment found its parts; the train where that takes too many.
FieldGroup as_sum(pgd::TrainField field, const std::vector<double>& ranges, double tolerance) {
  constexpr double kPeak = 4.0;  // largest over root mean square of what is left out
  const Eigen::VectorXd scale =
      Eigen::Map<const Eigen::VectorXd>(ranges.data(), static_cast<Eigen::Index>(ranges.size()));
  pgd::TensorTrain train = field.train();
  train.cores[0].left_unfolding() = scale.cwiseInverse().asDiagonal() * train.cores[0].left_unfolding();
  const double bound = tolerance / kPeak * std::sqrt(pgd::full_size(train));
  pgd::Separation sum = pgd::separate(train, bound);
  if (sum.status != Termination::converged) return field;
  const Eigen::MatrixXd weights =
      scale.asDiagonal() * sum.tensor.factors[0] * sum.tensor.weights.asDiagonal();
  sum.tensor.factors.erase(sum.tensor.factors.begin());
  return pgd::SeparatedField(field.axes(), field.outputs(), std::move(sum.tensor.factors), weights);
}

}  // namespace

Solution solve_by_pgd(const Plan& plan, const models::ParametricModel& model, const BuildOptions& options,
                      long max_evaluations, const ProgressCallback& progress) {
  const ModelSystem system(model);
  const pgd::AdaptiveProblem problem = problem_of(plan, model, system);
  const std::string strategy = strategy_of(plan);
  pgd::SlabOptions slabs;
  slabs.tolerance = plan.relative;
  slabs.max_evaluations = max_evaluations;
  slabs.max_cells = plan.builder.max_cells;
  slabs.max_nodes = plan.builder.max_nodes.value_or(slabs.max_nodes);
  slabs.max_rank = plan.builder.max_rank.value_or(slabs.max_rank);
  slabs.guards = plan.builder.guards.value_or(slabs.guards);
  slabs.seed = plan.builder.seed;
  slabs.progress = progress;
  slabs.checkpoint = checkpoint_writer(plan, options);
  pgd::SlabResult result = marched(problem, strategy, slabs, plan, options);
  if (result.pieces.empty()) {
    throw NoResultError(fmt::format("the march by the strategy \"{}\" has no result on the first slab: {}",
                                    strategy, result.message));
  }
  Solution solution;
  solution.record = record_of(result, strategy);
  solution.record.message += costly_slabs(result, model);
  solution.spent.nonlinearity = result.error;
  for (pgd::TrainField& field : result.pieces) solution.pieces.push_back(Piece{{std::move(field)}});
  if (strategy != "enrichment") return solution;
  // Slabs are joined as trains: a sum over all of the time has fewer terms than those of all slabs together.
  if (std::optional<Solution> joined = compacted(solution, compaction_of(plan, kShareOfJoining)))
    solution = std::move(*joined);
  const double tolerance = kShareOfSum * plan.relative;
  for (Piece& piece : solution.pieces)
    piece = Piece{{as_sum(*piece.groups().front().train(), result.ranges, tolerance)}};
  solution.spent.compression += tolerance;
  return solution;
}

}  // namespace samara::codebooks
