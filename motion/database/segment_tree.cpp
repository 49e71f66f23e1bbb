#include "samara/motion/database/segment_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>

namespace samara::motion {

namespace {

std::vector<Eigen::Index> all_segments(const MotionDatabase& database) {
  std::vector<Eigen::Index> all(database.segments.size());
  std::iota(all.begin(), all.end(), Eigen::Index{0});
  return all;
}

/// Where segments begin, in the metric. Copies differ in signs: of each start the one is taken in which
/// those are positive that are largest in the mean. So all lie on one side, and most copies of a place
/// that is looked for are far from them.
Eigen::MatrixXd places_of_starts(const MotionDatabase& database, const std::vector<Eigen::Index>& segments,
                                 const MovingStates& moving, const StateMetric& metric) {
  const auto size = static_cast<Eigen::Index>(moving.reduced_size());
  Eigen::MatrixXd places(std::ssize(segments), size);
  Eigen::VectorXd state, place(size);
  const std::span<double> numbers(place.data(), static_cast<std::size_t>(size));
  for (Eigen::Index p = 0; p < places.rows(); ++p) {
    state = database.starts.row(segments[static_cast<std::size_t>(p)]);
    moving.reduce({state.data(), static_cast<std::size_t>(state.size())}, numbers);
    metric.place(numbers);
    places.row(p) = place;
  }
  Eigen::MatrixXd signs(moving.copies(), size);
  for (int copy = 0; copy < moving.copies(); ++copy) {
    place.setOnes();
    moving.turn_to_copy(copy, numbers);
    signs.row(copy) = place;
  }
  std::vector<Eigen::Index> order(static_cast<std::size_t>(size));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const Eigen::RowVectorXd sizes = places.cwiseAbs().colwise().sum();
  std::ranges::stable_sort(order, std::greater<>(), [&](Eigen::Index i) { return sizes[i]; });
  for (Eigen::Index p = 0; p < places.rows(); ++p) {
    Eigen::Index best = 0;
    for (Eigen::Index copy = 1; copy < signs.rows(); ++copy) {
      const auto first =
          std::ranges::find_if(order, [&](Eigen::Index i) { return signs(copy, i) != signs(best, i); });
      if (signs(copy, *first) * places(p, *first) > 0.0) best = copy;
    }
    places.row(p) = places.row(p).cwiseProduct(signs.row(best));
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

SegmentTree::Places SegmentTree::places(std::span<const double> state) const {
  Places places;
  places.copies = static_cast<std::size_t>(moving_.copies());
  places.dimensions = static_cast<std::size_t>(moving_.reduced_size());
  const std::span<double> first = std::span(places.numbers).first(places.dimensions);
  moving_.reduce(state, first);
  metric_.place(first);
  for (std::size_t k = 1; k < places.copies; ++k) {
    const std::span<double> copy =
        std::span(places.numbers).subspan(k * places.dimensions, places.dimensions);
    std::ranges::copy(first, copy.begin());
    moving_.turn_to_copy(static_cast<int>(k), copy);
  }
  return places;
}

std::size_t SegmentTree::nearest(const Places& places, std::span<NearSegment> found, double within) const {
  const std::size_t wanted = std::min(found.size(), kMost);
  std::array<Eigen::Index, kMost> points;
  std::array<double, kMost> squares;
  const std::size_t count =
      points_.nearest_to_any(places.all(), std::span(points).first(wanted), squares, within * within);
  for (std::size_t k = 0; k < count; ++k)
    found[k] = {segments_[static_cast<std::size_t>(points[k])], std::sqrt(squares[k])};
  return count;
}

}  // namespace samara::motion
