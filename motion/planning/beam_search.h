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
  double cost = 0.0;  ///< fall_cost.h
};

/// A fall that is kept at a decision.
struct BeamNode {
  FallPoint point;
  std::vector<double> target;  ///< of the piece that led here
  int parent = -1;             ///< in the round before
  double t_from = 0.0;         ///< when that piece began
  double rank = 0.0;
};

/// All that a search knows, between two of its rounds: a search that goes on from here finds the same falls to the bit.
struct BeamState {
  struct Finished {
    int round = 0, index = 0;  ///< after the nodes of that round
    double cost = 0.0;
  };
  std::vector<std::vector<BeamNode>> rounds;  ///< what goes on, round by round; the first is the start
  std::vector<std::vector<BeamNode>> ended;   ///< beside them, what came to its end
  std::vector<Finished> finished;
  std::vector<PlanningStep> history;
  long pieces = 0;
  double lowest = 0.0;  ///< m, to which any fall has come
  int sunk_in = 0;      ///< round in which it came a semi-length further down

  static BeamState from(const FallPoint& start);
};

struct BeamResult {
  std::vector<FoundFall> falls;  ///< that came to the ground, or to the end of the time; best first
  bool cancelled = false;
  std::string lost;  ///< why no fall came to its end; empty: some did
};

/// Falls from decision to decision: of each that is kept, `children` continuations (as before, by a jitter, as falls
/// of the database did that were of the kind that is asked, anyhow); of all of these the best `beam` are kept, at
/// most four of one parent, by their cost (fall_cost.h), and by how far off they stand.
/// @param state where the search begins, and, when it is cancelled, where it can go on
/// @param keep called after each round
BeamResult search_beam(const PlannedFall& fall, BeamState& state, const ProgressCallback& progress,
                       const std::function<void()>& keep = {});

}  // namespace samara::motion
