#pragma once

#include <filesystem>
#include <string>

#include "samara/flow/march/solve_flow.h"

namespace samara::flow {

/// A plan of a flow (TOML, docs/flow.md): the table [flow], with [flow.extent] in it.
struct FlowPlan {
  FlowCase flow;
  FlowEnd end = FlowEnd::mean;
  double max_time = 200.0;
  double max_memory = 2e9;
  std::uint64_t seed = 1;
  int threads = 0;
  std::string title;
  std::string text;  ///< as read
};

/// @throws InputError, with file and line, for unknown keys, kinds and units, and values that are none of theirs
FlowPlan read_flow_plan(const std::filesystem::path& path);
FlowPlan parse_flow_plan(const std::string& text, const std::string& name);

}  // namespace samara::flow
