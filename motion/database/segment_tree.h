#pragma once

#include <span>
#include <vector>

#include "samara/motion/database/motion_database.h"
#include "samara/motion/search/near_points.h"

namespace samara::motion {

struct NearSegment {
  Eigen::Index segment = 0;
  double distance =
      0.0;  ///< of the states, in the database's metric, the nearest of the body's symmetric copies
};

/// Segments by the states in which they begin. Searches do not allocate, and may come from several threads.
class SegmentTree {
 public:
  /// Most segments that are asked for at once.
  static constexpr std::size_t kMost = 32;

  explicit SegmentTree(const MotionDatabase& database);
  /// Of some of its segments.
  SegmentTree(const MotionDatabase& database, std::vector<Eigen::Index> segments);

  /// The segments that begin nearest to a state, each once, the nearest first.
  /// @param found as many as are wanted, kMost at most
  /// @param slack as NearPoints::nearest
  /// @returns how many there are
  std::size_t nearest(std::span<const double> state, std::span<NearSegment> found, double slack = 0.0) const;

  const MovingStates& moving_states() const { return moving_; }

 private:
  MovingStates moving_;
  StateMetric metric_;
  std::vector<Eigen::Index> segments_;  // a point for each of their copies
  NearPoints points_;
};

}  // namespace samara::motion
