#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "samara/motion/planning/window_search.h"

namespace samara::motion {

/// All that planning knows, as a value: what goes on from it comes to the same motion, to the bit.
struct PlanningState {
  // The search under way: the rest of a fall behind knots that stay.
  std::vector<CourseKnot> head;
  FallPoint start;
  BeamState beam;
  std::optional<RefiningState> refining;  ///< when the beam has come to its end

  // The best course of the searches before; none: no knots and no duration.
  std::vector<CourseKnot> knots;
  double longest = 0.0;  ///< s, for which it was integrated
  int closings = 0;
  std::vector<PlanningStep> history;
};

/// What a plan asks for, number by number: only a state of the very same plan is gone on from.
std::string identity_of(const MotionPlan& plan);

/// HDF5, "samara-planning" 0.1.
/// @throws ArgumentError if the file cannot be written
void save_state(const PlanningState& state, const MotionPlan& plan, const std::filesystem::path& path);

/// @throws InputError for a file that is none, damaged, of another plan, or of another version of this program.
PlanningState load_state(const MotionPlan& plan, const std::filesystem::path& path);

}  // namespace samara::motion
