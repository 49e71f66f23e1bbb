#pragma once

#include <functional>
#include <vector>

#include "samara/base/progress.h"
#include "samara/motion/courses/coefficient_course.h"
#include "samara/motion/planning/fall_lanes.h"

namespace samara::motion {

/// A fall as it was found.
struct FoundFall {
  std::vector<CourseKnot> knots;
  FallPoint end;
  double cost = 0.0;
};

struct BeamResult {
  std::vector<FoundFall> falls;  ///< that came to the ground, or to the end of the time; best first
  std::vector<PlanningStep> history;
  bool cancelled = false;
  /// That none came to the ground: no number was finite, or there were too many decisions.
  bool lost = false;
};

/// Falls from decision to decision: of each that is kept, `children` continuations; of all of these the best `beam` are
/// kept, at most four of one parent. What they cost is, over the height fallen, the squared deviation, the changes of
/// coefficients, and the acceleration that turbulence would have to give; and the deviation where they stand.
BeamResult search_beam(const PlannedFall& fall, const FallPoint& start, const ProgressCallback& progress);

}  // namespace samara::motion
