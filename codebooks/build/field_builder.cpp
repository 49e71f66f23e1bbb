#include "samara/codebooks/build/field_builder.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/codebooks/fields/field_codebook.h"
#include "samara/codebooks/fields/ready_field.h"
#include "samara/pgd/linear/enrichment.h"

namespace samara::codebooks {

double first_aim(const Plan& plan) {
  return 0.5 * plan.relative;
}

double next_aim(double aim, double error, const Plan& plan) {
  constexpr double kSafety = 0.6, kLeast = 0.2, kMost = 0.7;
  // The error goes with the aim, more or less; a smaller one than needed is costly, over decades above all.
  return aim * (std::isfinite(error) ? std::clamp(kSafety * plan.relative / error, kLeast, kMost) : kLeast);
}

Solution solve_field(const Plan& plan, double aim, int attempt, const ProgressCallback& progress) {
  pgd::ParametricProblem problem = ready_problem(plan, aim);
  pgd::EnrichOptions options;
  options.projection = pgd::Projection::minimal_residual;  // of time there is a first derivative
  options.residual_tolerance = aim;
  options.update_sweeps = 4;
  options.update_tolerance = 1e-2;
  options.max_rank = 100;
  options.seed = plan.builder.seed;
  options.progress = progress;
  const pgd::EnrichResult result = enrich(problem.assemble(), options);
  add_steady_part(plan, problem);
  const models::StateInfo& output = plan.field->info.states.front();
  Solution solution;
  solution.pieces = {field_piece(problem, result.solution, {output.name, output.unit})};
  solution.record = enrichment_record(result);
  solution.record.rounds = attempt;
  std::vector<int> nodes;
  for (const pgd::Axis& axis : problem.axes()) nodes.push_back(axis.size());
  solution.record.message += fmt::format(", on {} nodes", fmt::join(nodes, " x "));
  return solution;
}

ModelDescription describe_field(const Plan& plan) {
  const models::ModelInfo& info = plan.field->info;
  ModelDescription description{.name = info.name,
                               .title = info.title,
                               .equations = info.equations,
                               .frames = info.frames,
                               .source = info.source,
                               .fixed = plan.fixed,
                               .fixed_units = {}};
  for (const models::ParameterInfo& parameter : info.parameters) {
    if (plan.fixed.contains(parameter.name)) description.fixed_units[parameter.name] = parameter.unit;
  }
  return description;
}

}  // namespace samara::codebooks
