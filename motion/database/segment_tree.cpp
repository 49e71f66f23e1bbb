#include "samara/motion/database/segment_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace samara::motion {

namespace {

std::vector<Eigen::Index> all_segments(const MotionDatabase& database) {
  std::vector<Eigen::Index> all(database.segments.size());
  std::iota(all.begin(), all.end(), Eigen::Index{0});
  return all;
}

/// Where segments begin, in the metric, all copies of each after another.
Eigen::MatrixXd places_of_starts(const MotionDatabase& database, const std::vector<Eigen::Index>& segments,
                                 const MovingStates& moving, const StateMetric& metric) {
  const int copies = moving.copies();
  Eigen::MatrixXd places(std::ssize(segments) * copies, moving.reduced_size());
  Eigen::VectorXd state, place(moving.reduced_size());
  for (Eigen::Index p = 0; p < places.rows(); ++p) {
    state = database.starts.row(segments[static_cast<std::size_t>(p / copies)]);
    const std::span<double> numbers(place.data(), static_cast<std::size_t>(place.size()));
    moving.reduce({state.data(), static_cast<std::size_t>(state.size())}, numbers);
    moving.turn_to_copy(static_cast<int>(p % copies), numbers);
    metric.place(numbers);
    places.row(p) = place;
  }
  return places;
}

}  // namespace

SegmentTree::SegmentTree(const MotionDatabase& database) : SegmentTree(database, all_segments(database)) {}

SegmentTree::SegmentTree(const MotionDatabase& database, std::vector<Eigen::Index> segments)
    : moving_(database.moving_states()),
      metric_(database.metric()),
      segments_(std::move(segments)),
      points_(places_of_starts(database, segments_, moving_, metric_)) {}

std::size_t SegmentTree::nearest(std::span<const double> state, std::span<NearSegment> found,
                                 double slack) const {
  constexpr std::size_t kDimensions = 9;
  std::array<double, kDimensions> numbers;
  const std::span<double> place = std::span(numbers).first(static_cast<std::size_t>(moving_.reduced_size()));
  moving_.reduce(state, place);
  metric_.place(place);
  const std::size_t wanted = std::min(found.size(), kMost);
  const auto copies = static_cast<std::size_t>(moving_.copies());
  std::array<Eigen::Index, NearPoints::kMost> points;
  std::array<double, NearPoints::kMost> squares;
  std::size_t have = 0;
  // Copies of one segment may all be among the nearest; rarely are.
  for (std::size_t asked = std::min(wanted + copies, wanted * copies);; asked = wanted * copies) {
    const std::size_t count = points_.nearest(place, std::span(points).first(asked), squares, slack);
    have = 0;
    for (std::size_t k = 0; k < count && have < wanted; ++k) {
      const Eigen::Index segment = segments_[static_cast<std::size_t>(points[k]) / copies];
      const auto known = found.first(have);
      if (std::ranges::find(known, segment, &NearSegment::segment) != known.end()) continue;
      found[have++] = {segment, std::sqrt(squares[k])};
    }
    if (have == wanted || count < asked || asked == wanted * copies) return have;
  }
}

}  // namespace samara::motion
