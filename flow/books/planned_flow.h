#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "samara/codebooks/build/build.h"
#include "samara/flow/files/flow_plan.h"

/// The flows that a book of a plan stands for.
namespace samara::flow {

/// The plan's flow at values of its box, in its order (angle_of_attack [rad], log10_reynolds).
FlowCase flow_case_at(const FlowPlan& plan, const std::vector<double>& point);

/// The same, solved. @param warning is told what the flow warns of, and where, also if there is no result
/// @throws NoResultError if it is neither steady nor averaged in the end
FlowResult solve_at(const FlowPlan& plan, const std::vector<double>& point, const ProgressCallback& progress,
                    const std::function<void(const std::string&)>& warning = {});

/// The same flows on twice the cells, which say what the grid is worth.
FlowPlan finer_plan(const FlowPlan& plan);

/// Refuses a plan of whose flows some would be refused, such as at the angle of its box where the body is widest or
/// nearest to a border, or on twice the cells: after hours of others it would be late to say so.
/// @throws ArgumentError also for a plan without a box, or with fewer calls than a first grid takes
void check_book(const FlowPlan& plan);

/// Where these flows are kept, beside those of the book; empty for no file.
std::filesystem::path finer_checkpoint(const std::filesystem::path& checkpoint);

/// What the flows are about, as the model of a codebook of fields says it: the plan, and which mesh was in the file
/// that it names, if it names one.
std::string book_source(const FlowPlan& plan);
inline constexpr const char* kPlanSource = "the plan";

/// What checkpoints of a book must agree in: the plan, the revision of the solver, and the mesh if there is one.
std::string checkpointed_text(const FlowPlan& plan);

/// Runs the build of a book as codebooks::build() has it: what was cancelled once stays cancelled, and the checkpoint
/// of a build that is done is removed, unless the options keep it.
/// @throws InputError if another file stands in the place of finer_checkpoint()
codebooks::BuildResult run_build(
    const codebooks::BuildOptions& options,
    const std::function<codebooks::BuildResult(const codebooks::BuildOptions& options)>& build);

/// Lower and upper corner of the plan's box.
std::pair<std::vector<double>, std::vector<double>> corners_of(const FlowPlan& plan);

}  // namespace samara::flow
