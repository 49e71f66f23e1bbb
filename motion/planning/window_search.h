#pragma once

#include <functional>
#include <vector>

#include "samara/base/progress.h"
#include "samara/motion/planning/beam_search.h"
#include "samara/motion/planning/fall_replay.h"

namespace samara::motion {

/// All that refining knows, between two of its windows: as BeamState.
struct RefiningState {
  std::vector<CourseKnot> knots;  ///< as they are now
  FoundFall best;                 ///< along them, or the one that it began with
  int sweep = 0;
  std::size_t first = 0;      ///< knot at which the next window begins
  bool has_improved = false;  ///< this sweep, so far
  BookUse use;                ///< in all windows
  std::vector<PlanningStep> history;

  static RefiningState from(const PlannedFall& fall, const FallPoint& start, const FoundFall& found);
};

/// Moves the coefficients at the knots: Gauss and Newton's method over windows of six knots that look ten knots
/// ahead, one window after another down the fall, within the box, with the exact tangents of the steps, or those of
/// the plan's codebook. What they minimise is their part of the cost that the search has (fall_cost.h), all but the
/// kinds of segments, which have no tangents. Knots are first put at the thirds of long pieces, unless turbulence is
/// what pieces cost. A window is taken if it improves what it looks at and the whole, kinds included.
/// @param state where it begins, and, when it is cancelled, where it can go on
/// @param keep called after each window
/// @returns false if it was cancelled; else state.best is the fall, not worse than the one it began with
bool refine_in_windows(const PlannedFall& fall, const FallPoint& start, RefiningState& state,
                       const ProgressCallback& progress, const std::function<void()>& keep = {});

}  // namespace samara::motion
