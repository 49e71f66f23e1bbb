#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "samara/motion/database/motion_database.h"
#include "samara/motion/search/near_points.h"

namespace samara::motion {

struct NearSegment {
  Eigen::Index segment = 0;
  /// Of the states, in the database's metric, the nearest of the body's symmetric copies.
  double distance = 0.0;
};

/// Segments by the states in which they begin. Searches do not allocate, and may come from several threads.
class SegmentTree {
 public:
  /// Most segments that are asked for at once.
  static constexpr std::size_t kMost = 32;

  explicit SegmentTree(const MotionDatabase& database);
  /// Of some of its segments.
  SegmentTree(const MotionDatabase& database, std::vector<Eigen::Index> segments);

  /// A state as searches take it: its place in the metric, and those of its symmetric copies.
  struct Places {
    static constexpr std::size_t kMostCopies = 4, kMostDimensions = 9;
    std::array<double, kMostCopies * kMostDimensions> numbers;
    std::size_t copies = 0, dimensions = 0;
    std::span<const double> all() const { return std::span(numbers).first(copies * dimensions); }
    std::span<const double> copy(std::size_t k) const { return all().subspan(k * dimensions, dimensions); }
  };
  Places places(std::span<const double> state) const;

  /// The segments that begin nearest to a state, each once, the nearest first.
  /// @param found as many as are wanted, kMost at most
  /// @param within only those nearer than this
  /// @returns how many there are
  std::size_t nearest(const Places& places, std::span<NearSegment> found,
                      double within = std::numeric_limits<double>::infinity()) const;
  std::size_t nearest(std::span<const double> state, std::span<NearSegment> found) const {
    return nearest(places(state), found);
  }

  const MovingStates& moving_states() const { return moving_; }

 private:
  MovingStates moving_;
  StateMetric metric_;
  std::vector<Eigen::Index> segments_;  // a point each
  NearPoints points_;
};

}  // namespace samara::motion
