#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "samara/flow/files/flow_plan.h"
#include "samara/flow/march/solve_flow.h"

/// Flow files: HDF5 of the format "samara-flow" 0.1 (docs/flow_file.md), all in body lengths and U.
namespace samara::flow {

inline constexpr const char* kFlowFormat = "samara-flow";
inline constexpr const char* kFlowVersion = "0.1";

/// @throws ArgumentError if it cannot be written
void save_flow(const FlowResult& result, const FlowPlan& plan, const std::filesystem::path& path);

/// Whether the file says that it is one.
bool is_flow_file(const std::filesystem::path& path);

/// A field in the centres of cells, with margins of 0.
struct CentreField {
  std::string name, unit;
  Field values;
};

/// What a flow file holds of a flow: u, v, (w), p, k (modelled and resolved), k_modelled, k_resolved, epsilon; of a
/// laminar one neither k_modelled nor epsilon.
std::vector<CentreField> centre_fields(const FlowResult& result);

/// What a flow file tells.
struct FlowSummary {
  std::string status, message, title, plan, generator;
  double reynolds = 0.0, angle_of_attack = 0.0;
  /// u'/U of the stream; none: a file of an earlier version, which does not say it.
  std::optional<double> intensity;
  bool moving = false;  ///< the body moves: fields are those of an instant
  double drag = 0.0, lift = 0.0, moment = 0.0;
  std::optional<double> drag_half_width;                  ///< of the 95 % interval; none: not known
  double drag_rms = 0.0, lift_rms = 0.0, strouhal = 0.0;  ///< NaN: not known
  double bubble_end = 0.0, averaged_time = 0.0, time = 0.0;
  FlowChecks checks;
};

/// A flow from its file.
struct StoredFlow {
  explicit StoredFlow(const MacGrid& of) : grid(of) {}

  MacGrid grid;
  FlowSummary summary;
  /// u, v, (w), p, k (modelled and resolved), k_modelled, k_resolved, epsilon
  std::vector<CentreField> fields;
  Field open;  ///< of cells

  /// @throws ArgumentError, naming those that are there, for another
  const CentreField& field(const std::string& name) const;
};

/// @throws InputError if it is none, of another version, damaged, of fewer than two cells a direction, or
/// holds what is not finite, or k < 0 or eps <= 0 in the fluid
StoredFlow load_flow(const std::filesystem::path& path);

}  // namespace samara::flow
