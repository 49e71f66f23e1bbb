#include "samara/flow/books/planned_flow.h"

#include <cmath>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/flow/march/flow_checkpoint.h"

namespace samara::flow {

FlowCase flow_case_at(const FlowPlan& plan, const std::vector<double>& point) {
  FlowCase flow = plan.flow;
  for (std::size_t k = 0; k < plan.box.size(); ++k) {
    if (plan.box[k].name == "angle_of_attack") {
      flow.angle_of_attack = point[k];
    } else {
      flow.reynolds = std::pow(10.0, point[k]);
    }
  }
  return flow;
}

FlowResult solve_at(const FlowPlan& plan, const std::vector<double>& point,
                    const ProgressCallback& progress) {
  const FlowCase flow = flow_case_at(plan, point);
  FlowOptions options;
  options.end = plan.end;
  options.max_time = plan.max_time;
  options.max_memory = plan.max_memory;
  options.seed = plan.seed;
  options.threads = plan.threads;
  const std::string where = fmt::format("flow at {:.4g} rad, Re {:.4g}", flow.angle_of_attack, flow.reynolds);
  if (progress) {
    options.progress = [&](const Progress& report) { return progress({where, report.fraction}); };
  }
  FlowResult result = solve_flow(flow, options);
  if (result.status != FlowStatus::steady && result.status != FlowStatus::averaged)
    throw NoResultError(
        fmt::format("the {} ends as \"{}\": {}", where, to_string(result.status), result.message));
  return result;
}

FlowPlan finer_plan(const FlowPlan& plan) {
  FlowPlan finer = plan;
  finer.flow.cells_per_length *= 2;
  finer.text += "\n# twice the cells";
  return finer;
}

std::filesystem::path finer_checkpoint(const std::filesystem::path& checkpoint) {
  return checkpoint.empty() ? checkpoint : std::filesystem::path(checkpoint.string() + ".finer");
}

std::string checkpointed_text(const FlowPlan& plan) {
  return fmt::format("{}\n# solver of flows, revision {}", plan.text, kRevision);
}

codebooks::BuildResult run_build(
    const codebooks::BuildOptions& options,
    const std::function<codebooks::BuildResult(const codebooks::BuildOptions& options)>& build) {
  bool cancelled = false;
  codebooks::BuildOptions guarded = options;
  if (options.progress) {
    guarded.progress = [&](const Progress& report) {
      return !(cancelled = cancelled || !options.progress(report));
    };
  }
  codebooks::BuildResult result = build(guarded);
  result.resumable = result.resumable || cancelled;
  if (!options.checkpoint.empty() && !options.keep_checkpoint && !result.resumable) {
    std::error_code ignored;
    std::filesystem::remove(options.checkpoint, ignored);
  }
  return result;
}

std::pair<std::vector<double>, std::vector<double>> corners_of(const FlowPlan& plan) {
  std::pair<std::vector<double>, std::vector<double>> corners;
  for (const codebooks::BoxEntry& entry : plan.box) {
    corners.first.push_back(entry.lower);
    corners.second.push_back(entry.upper);
  }
  return corners;
}

}  // namespace samara::flow
