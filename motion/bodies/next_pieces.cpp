#include "samara/motion/bodies/next_pieces.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/batch/watch_batch.h"

namespace samara::motion {

namespace {

/// The 90 % point of the distances from the ends of kept segments to the nearest start in another run; the graph's
/// threshold where none has a neighbour.
double reach_of(const MotionGraph& graph) {
  std::vector<double> nearest;
  for (std::size_t n = 0; n + 1 < graph.first_edge.size(); ++n) {
    for (Eigen::Index k = graph.first_edge[n]; graph.component[n] == 0 && k < graph.first_edge[n + 1]; ++k) {
      const double distance = graph.edges[static_cast<std::size_t>(k)].distance;
      if (distance == 0.0) continue;  // its own run
      nearest.push_back(distance);
      break;
    }
  }
  if (nearest.empty()) return graph.threshold;
  const auto high = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() * 9 / 10);
  std::ranges::nth_element(nearest, high);
  return *high;
}

double longest_duration(const MotionDatabase& database) {
  return std::ranges::max(database.segments, {}, &MotionSegment::duration).duration;
}

}  // namespace

NextPieces::NextPieces(MotionDatabase database) : NextPieces(database, motion_graph(database)) {}

NextPieces::NextPieces(MotionDatabase database, MotionGraph graph)
    : database_(std::move(database)),
      graph_(std::move(graph)),
      tree_(database_),
      metric_(database_.metric()),
      chain_(kind_chain(database_).chain) {
  std::vector<double> durations;
  for (const MotionSegment& segment : database_.segments) durations.push_back(segment.duration);
  const auto middle = durations.begin() + static_cast<std::ptrdiff_t>(durations.size() / 2);
  std::ranges::nth_element(durations, middle);
  median_duration_ = *middle;
  reach_ = reach_of(graph_);
  try_kinds();
  const MovingStates& moving = tree_.moving_states();
  places_.resize(moving.reduced_size(), database_.segment_count());
  Eigen::VectorXd state;
  for (Eigen::Index n = 0; n < database_.segment_count(); ++n) {
    state = database_.starts.row(n);
    const std::span<double> place(places_.col(n).data(), static_cast<std::size_t>(places_.rows()));
    moving.reduce({state.data(), static_cast<std::size_t>(state.size())}, place);
    metric_.place(place);
  }
  near_ = std::make_unique<SegmentTree>(sturdy_tree());
}

const Eigen::VectorXd& NextPieces::coefficients(const NextPiece& piece) const {
  const MotionSegment& segment = database_.segments[static_cast<std::size_t>(piece.segment)];
  return database_.runs[static_cast<std::size_t>(segment.run)].coefficients;
}

NextPiece NextPieces::piece_of(const NearSegment& found) const {
  return {found.segment, database_.segments[static_cast<std::size_t>(found.segment)].kind, found.distance};
}

NextPiece NextPieces::of_kind(std::span<const double> state, EventKind kind) const {
  NearSegment found;
  if (tree_.nearest(state, {&found, 1}, kind) == 0)
    throw ArgumentError(fmt::format("the database has no segment of the kind {}", to_string(kind)));
  return piece_of(found);
}

/// Runs each segment's coefficients from the starts of others until the next event.
void NextPieces::try_kinds() {
  constexpr std::size_t kTrials = 3;
  const Eigen::Index count = database_.segment_count();
  std::vector<Eigen::Index> from, with;
  std::array<NearSegment, kTrials + 1> found;
  Eigen::VectorXd state;
  for (Eigen::Index n = 0; n < count; ++n) {
    state = database_.starts.row(n);
    const std::size_t near = tree_.nearest({state.data(), static_cast<std::size_t>(state.size())}, found);
    for (std::size_t k = 0; k < near; ++k) {
      if (found[k].segment == n || found[k].distance >= reach_) continue;
      from.push_back(found[k].segment);
      with.push_back(n);
    }
  }
  sturdy_.assign(static_cast<std::size_t>(count), 1);
  if (from.empty()) return;
  std::vector<std::string> free = database_.coefficient_names;
  for (const std::string& name : database_.state_names) free.push_back(name + "(0)");
  const models::ParametricModel base = database_.parametric_model();
  const models::ParametricModel model(base.shared_model(), database_.fixed, free);
  const Eigen::Index coefficients = database_.lower.size();
  Eigen::MatrixXd lanes(static_cast<Eigen::Index>(from.size()), model.free_count());
  std::vector<EventFinder> finders;
  for (std::size_t k = 0; k < from.size(); ++k) {
    const auto lane = static_cast<Eigen::Index>(k);
    lanes.row(lane).head(coefficients) = this->coefficients({with[k], EventKind::swing_plus, 0.0});
    lanes.row(lane).tail(database_.starts.cols()) = database_.starts.row(from[k]);
    finders.emplace_back(tree_.moving_states(), database_.events);
  }
  std::vector<char> kept(from.size(), 0);
  watch_batch(model, lanes,
              [&](Eigen::Index lane, double t, std::span<const double> x) {
                const auto k = static_cast<std::size_t>(lane);
                if (!finders[k].see(t, x)) return true;
                kept[k] =
                    finders[k].event().kind == database_.segments[static_cast<std::size_t>(with[k])].kind;
                return false;
              },
              {.step = database_.step, .interval = database_.step, .end = 4.0 * longest_duration(database_)});
  for (std::size_t k = 0; k < from.size(); ++k) {
    if (kept[k] == 0) sturdy_[static_cast<std::size_t>(with[k])] = 0;
  }
}

Eigen::Index NextPieces::draw_segment(Stream& stream) const {
  auto pick = static_cast<Eigen::Index>(stream.uniform() * static_cast<double>(graph_.kept));
  Eigen::Index segment = 0;
  for (; segment + 1 < database_.segment_count(); ++segment) {
    if (graph_.is_kept(segment) && pick-- == 0) break;
  }
  return segment;
}

SegmentTree NextPieces::sturdy_tree() const {
  std::vector<Eigen::Index> chosen;
  for (Eigen::Index n = 0; n < database_.segment_count(); ++n) {
    if (graph_.is_kept(n) && is_sturdy(n)) chosen.push_back(n);
  }
  for (Eigen::Index n = 0; chosen.empty() && n < database_.segment_count(); ++n) {
    if (graph_.is_kept(n)) chosen.push_back(n);
  }
  return {database_, std::move(chosen)};
}

std::size_t NextPieces::candidates(Eigen::Index followed, std::span<const double> state,
                                   std::span<NearSegment> found) const {
  if (followed < 0) return 0;
  constexpr std::size_t kCopies = 4, kDimensions = 9;
  const MovingStates& moving = tree_.moving_states();
  const auto size = static_cast<std::size_t>(moving.reduced_size());
  std::array<std::array<double, kDimensions>, kCopies> places;
  for (int copy = 0; copy < moving.copies(); ++copy) {
    const std::span<double> place = std::span(places[static_cast<std::size_t>(copy)]).first(size);
    moving.reduce(state, place);
    moving.turn_to_copy(copy, place);
    metric_.place(place);
  }
  std::size_t have = 0;
  const auto node = static_cast<std::size_t>(followed);
  for (Eigen::Index k = graph_.first_edge[node]; k < graph_.first_edge[node + 1] && have < found.size();
       ++k) {
    const Eigen::Index to = graph_.edges[static_cast<std::size_t>(k)].to;
    if (!graph_.is_kept(to) || !is_sturdy(to)) continue;
    double least = reach_ * reach_;
    const double* start = places_.data() + static_cast<std::size_t>(to) * size;
    for (int copy = 0; copy < moving.copies(); ++copy) {
      double square = 0.0;
      for (std::size_t i = 0; i < size; ++i) {
        const double gap = places[static_cast<std::size_t>(copy)][i] - start[i];
        square += gap * gap;
      }
      least = std::min(least, square);
    }
    if (least < reach_ * reach_) found[have++] = {to, std::sqrt(least)};
  }
  std::ranges::sort(found.first(have), {}, &NearSegment::distance);
  return have;
}

NextPiece NextPieces::after(Eigen::Index followed, std::span<const double> state, Stream& stream) const {
  std::array<NearSegment, kMostEdges> found;
  const std::size_t count = candidates(followed, state, found);
  if (count == 0) return anywhere(state, stream);
  return piece_of(found[static_cast<std::size_t>(stream.uniform() * static_cast<double>(count))]);
}

NextPiece NextPieces::after(Eigen::Index followed, std::span<const double> state, std::span<const int> past,
                            Stream& stream) const {
  const auto kind = static_cast<EventKind>(chain_.draw(past, stream));
  std::array<NearSegment, kMostEdges> found;
  const std::size_t count = candidates(followed, state, found);
  for (std::size_t k = 0; k < count; ++k) {
    if (database_.segments[static_cast<std::size_t>(found[k].segment)].kind == kind)
      return piece_of(found[k]);
  }
  if (count == 0) return anywhere(state, stream);
  return piece_of(found[static_cast<std::size_t>(stream.uniform() * static_cast<double>(count))]);
}

NextPiece NextPieces::anywhere(std::span<const double> state, Stream& stream) const {
  constexpr std::size_t kNear = 4;
  std::array<NearSegment, kNear> found;
  const std::size_t count = near_->nearest(state, found, {}, 4.0);
  std::size_t choices = 1;
  while (choices < count && found[choices].distance < reach_) ++choices;
  return piece_of(found[static_cast<std::size_t>(stream.uniform() * static_cast<double>(choices))]);
}

}  // namespace samara::motion
