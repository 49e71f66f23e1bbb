#include "samara/motion/database/segment_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace samara::motion {

SegmentTree::SegmentTree(const MotionDatabase& database)
    : moving_(database.moving_states()), metric_(database.metric()) {
  std::array<std::vector<Eigen::Index>, kEventKinds + 1> chosen;
  for (Eigen::Index n = 0; n < database.segment_count(); ++n) {
    chosen[static_cast<std::size_t>(database.segments[static_cast<std::size_t>(n)].kind)].push_back(n);
    chosen.back().push_back(n);
  }
  for (const auto& segments : chosen) parts_.push_back(part_of(database, segments));
}

SegmentTree::SegmentTree(const MotionDatabase& database, std::vector<Eigen::Index> segments)
    : moving_(database.moving_states()), metric_(database.metric()) {
  parts_.push_back(part_of(database, segments));
}

SegmentTree::Part SegmentTree::part_of(const MotionDatabase& database,
                                       const std::vector<Eigen::Index>& chosen) const {
  std::vector<Eigen::Index> segments;
  std::vector<double> places;
  const auto size = static_cast<std::size_t>(moving_.reduced_size());
  std::vector<double> reduced(size);
  Eigen::VectorXd state;
  for (const Eigen::Index n : chosen) {
    state = database.starts.row(n);
    for (int copy = 0; copy < moving_.copies(); ++copy) {
      moving_.reduce({state.data(), static_cast<std::size_t>(state.size())}, reduced);
      moving_.turn_to_copy(copy, reduced);
      metric_.place(reduced);
      places.insert(places.end(), reduced.begin(), reduced.end());
      segments.push_back(n);
    }
  }
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const Rows> points(places.data(), static_cast<Eigen::Index>(segments.size()),
                                      static_cast<Eigen::Index>(size));
  return {NearPoints(Eigen::MatrixXd(points)), std::move(segments)};
}

std::size_t SegmentTree::nearest(std::span<const double> state, std::span<NearSegment> found,
                                 std::optional<EventKind> kind, double slack) const {
  constexpr std::size_t kDimensions = 9;
  std::array<double, kDimensions> numbers;
  const std::span<double> place = std::span(numbers).first(static_cast<std::size_t>(moving_.reduced_size()));
  moving_.reduce(state, place);
  metric_.place(place);
  const std::size_t wanted = std::min(found.size(), kMost);
  const auto copies = static_cast<std::size_t>(moving_.copies());
  const Part& part = kind ? parts_[static_cast<std::size_t>(*kind)] : parts_.back();
  std::array<Eigen::Index, NearPoints::kMost> points;
  std::array<double, NearPoints::kMost> squares;
  std::size_t have = 0;
  // Copies of one segment may all be among the nearest; rarely are.
  for (std::size_t asked = std::min(wanted + copies, wanted * copies);; asked = wanted * copies) {
    const std::size_t count = part.points.nearest(place, std::span(points).first(asked), squares, slack);
    have = 0;
    for (std::size_t k = 0; k < count && have < wanted; ++k) {
      const Eigen::Index segment = part.segments[static_cast<std::size_t>(points[k])];
      const auto known = found.first(have);
      if (std::ranges::find(known, segment, &NearSegment::segment) != known.end()) continue;
      found[have++] = {segment, std::sqrt(squares[k])};
    }
    if (have == wanted || count < asked || asked == wanted * copies) return have;
  }
}

}  // namespace samara::motion
