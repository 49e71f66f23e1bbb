#include "samara/flow/books/planned_flow.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <span>
#include <system_error>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/flow/march/flow_checkpoint.h"
#include "samara/io/checksum.h"

namespace samara::flow {

namespace {

/// Where in the box the body takes most of the stream's width, and where it reaches farthest along and across the
/// stream, which may be between its ends.
std::array<std::vector<double>, 3> extremes_of(const FlowPlan& plan) {
  constexpr int kSteps = 256;
  const auto [lower, upper] = corners_of(plan);
  std::array<std::vector<double>, 3> extremes = {lower, lower, lower};
  std::array<double, 3> most{};
  for (int i = 0; i <= kSteps; ++i) {
    std::vector<double> point;
    for (std::size_t k = 0; k < lower.size(); ++k)
      point.push_back(std::lerp(lower[k], upper[k], static_cast<double>(i) / kSteps));
    const FlowCase flow = flow_case_at(plan, point);
    const PlacedShape body(flow.shape, Eigen::Vector3d::Zero(), flow.angle_of_attack);
    const std::array<double, 3> sizes = {blockage(flow), body.half_extent().x(), body.half_extent().y()};
    for (std::size_t m = 0; m < sizes.size(); ++m) {
      if (sizes[m] <= most[m]) continue;
      most[m] = sizes[m];
      extremes[m] = point;
    }
  }
  return extremes;
}

}  // namespace

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

FlowResult solve_at(const FlowPlan& plan, const std::vector<double>& point, const ProgressCallback& progress,
                    const std::function<void(const std::string&)>& warning) {
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
  if (warning) {
    for (const std::string& sentence : result.warnings) warning(fmt::format("{}: {}", where, sentence));
  }
  if (result.status != FlowStatus::steady && result.status != FlowStatus::averaged)
    throw NoResultError(
        fmt::format("the {} ends as \"{}\": {}", where, to_string(result.status), result.message));
  return result;
}

FlowPlan finer_plan(const FlowPlan& plan) {
  FlowPlan finer = plan;
  // Whole cells of the coarser grid, as that has them: its borders are those of the finer one, too.
  const double n = plan.flow.cells_per_length;
  Extent& extent = finer.flow.extent;
  for (double* length : {&extent.before, &extent.behind, &extent.side}) *length = std::round(*length * n) / n;
  finer.flow.cells_per_length *= 2;
  finer.text += "\n# twice the cells";
  return finer;
}

void check_book(const FlowPlan& plan) {
  if (plan.box.empty()) throw ArgumentError("a book of flows needs a box, which the plan does not have");
  const long least = plan.box.size() == 1 ? 4 : 11;
  require(plan.max_calls >= least, "max_calls", plan.max_calls,
          fmt::format("at least {}, the first grid and a flow along each coordinate", least),
          "a book of flows");
  const FlowPlan finer = finer_plan(plan);
  const auto [lower, upper] = corners_of(plan);
  std::vector<std::vector<double>> points = {lower, upper};
  for (const std::vector<double>& extreme : extremes_of(plan)) points.push_back(extreme);
  for (const std::vector<double>& point : points) {
    check_case(flow_case_at(plan, point), plan.max_memory);
    check_case(flow_case_at(finer, point), plan.max_memory);
  }
}

std::filesystem::path finer_checkpoint(const std::filesystem::path& checkpoint) {
  return checkpoint.empty() ? checkpoint : std::filesystem::path(checkpoint.string() + ".finer");
}

std::string book_source(const FlowPlan& plan) {
  // What other shapes are stands in the text of the plan.
  if (plan.flow.shape.kind != "mesh") return kPlanSource;
  return fmt::format("{}, mesh {:016x}", kPlanSource,
                     io::fnv1a(std::as_bytes(std::span(plan.flow.shape.sizes))));
}

std::string checkpointed_text(const FlowPlan& plan) {
  std::string text = fmt::format("{}\n# solver of flows, revision {}", plan.text, kRevision);
  // That of plans without a mesh stays as it was, and so do their checkpoints.
  if (const std::string source = book_source(plan); source != kPlanSource) text += "\n# " + source;
  return text;
}

codebooks::BuildResult run_build(
    const codebooks::BuildOptions& options,
    const std::function<codebooks::BuildResult(const codebooks::BuildOptions& options)>& build) {
  // It is not written before the book is done: after hours it would be late to refuse what stands there.
  codebooks::check_checkpoint_path(finer_checkpoint(options.checkpoint));
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
