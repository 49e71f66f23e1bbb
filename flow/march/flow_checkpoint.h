#pragma once

#include <filesystem>
#include <string>

#include "samara/codebooks/source/checkpoint.h"
#include "samara/flow/march/flow_run.h"
#include "samara/flow/march/solve_flow.h"

namespace samara::flow {

/// Of the solver: to be raised whenever the same case takes other bits, or the state holds other numbers.
inline constexpr int kRevision = 8;

/// What a result depends on: the case, and the options that matter to its bits.
std::string case_text(const FlowCase& flow, const FlowOptions& options);

/// Whether a file says that it is a checkpoint of a flow, also if it is damaged.
bool is_flow_checkpoint(const std::filesystem::path& file);

inline constexpr codebooks::CheckpointKind kFlowCheckpoint = {"a flow", is_flow_checkpoint};

/// The whole state, at once under its name: a run that goes on from it takes the same bits as one that was not
/// interrupted.
void save_checkpoint(FlowRun& run, const std::filesystem::path& path);

/// @returns false if there is no such file @throws InputError if it is of another case, or damaged
bool load_checkpoint(FlowRun& run, const std::filesystem::path& path);

}  // namespace samara::flow
