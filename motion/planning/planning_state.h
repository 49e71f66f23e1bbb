#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "samara/codebooks/source/checkpoint.h"
#include "samara/motion/planning/window_search.h"

namespace samara::motion {

/// All that planning knows, as a value: what goes on from it comes to the same motion, to the bit.
struct PlanningState {
  BeamState beam;
  std::optional<RefiningState> refining;  ///< when the beam has come to its end
};

/// What a plan asks for, number by number: only a state of the very same plan is gone on from.
std::string identity_of(const MotionPlan& plan);

/// HDF5, "samara-planning" 0.3.
/// @throws ArgumentError if the file cannot be written
void save_state(const PlanningState& state, const MotionPlan& plan, const std::filesystem::path& path);

/// Whether a file says that it is such a state, also if it is damaged.
bool is_planning_state(const std::filesystem::path& file);

inline constexpr codebooks::CheckpointKind kPlanningCheckpoint = {"a search for a motion", is_planning_state};

/// @throws InputError for a file that is none, damaged, of another plan, or of another version of this program.
PlanningState load_state(const MotionPlan& plan, const std::filesystem::path& path);

}  // namespace samara::motion
