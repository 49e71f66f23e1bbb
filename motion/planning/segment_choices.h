#pragma once

#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "samara/motion/database/segment_tree.h"
#include "samara/motion/planning/motion_plan.h"

namespace samara::motion {

/// What a database proposes where a fall is to be of a kind, or of a pattern: the coefficients of falls that
/// were of it, and that came by in a state like the one in which the body is. They are tried like any
/// others. Immutable, shared between threads.
class SegmentChoices {
 public:
  /// @throws ArgumentError for a database of another body, or of which no coefficient is one of the plan's box
  explicit SegmentChoices(const MotionPlan& plan);

  /// Proposals, those of the segments that begin nearest first, each run once.
  /// @param asked none: of any kind
  /// @param targets per proposal, coefficients of the box; those that the database does not change stay as they are
  /// given
  /// @returns how many there are
  std::size_t propose(std::span<const double> state, const AskedSegment* asked,
                      std::span<std::vector<double>> targets) const;

  /// How far a state is from the nearest in which a segment of what is asked has begun, in the metric of the database;
  /// infinite where none has.
  double distance(std::span<const double> state, const AskedSegment& asked) const;

 private:
  using Key = std::pair<std::optional<EventKind>, std::optional<Pattern>>;
  static Key key_of(const AskedSegment& asked);
  const SegmentTree* tree_of(const AskedSegment* asked) const;

  const MotionDatabase& database_;
  const std::vector<SteeredCoefficient>& box_;
  /// Of the database's coefficients, per coefficient of the box; -1: none.
  std::vector<Eigen::Index> columns_;
  SegmentTree tree_;
  std::map<Key, SegmentTree> of_asked_;  ///< of those that the plan's sequence asks for
};

}  // namespace samara::motion
