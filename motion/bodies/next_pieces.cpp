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

/// Segments that are looked at for a choice.
constexpr std::size_t kNear = 8;

}  // namespace

NextPieces::NextPieces(MotionDatabase database) : NextPieces(database, motion_graph(database)) {}

NextPieces::NextPieces(MotionDatabase database, MotionGraph graph)
    : database_(std::move(database)),
      graph_(std::move(graph)),
      tree_(database_),
      chain_(kind_chain(database_).chain) {
  std::vector<double> durations;
  for (const MotionSegment& segment : database_.segments) durations.push_back(segment.duration);
  const auto middle = durations.begin() + static_cast<std::ptrdiff_t>(durations.size() / 2);
  std::ranges::nth_element(durations, middle);
  median_duration_ = *middle;
  reach_ = reach_of(graph_);
  try_kinds();
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

NextPiece NextPieces::by_chain(std::span<const double> state, std::span<const int> past,
                               Stream& stream) const {
  const auto kind = static_cast<EventKind>(chain_.draw(past, stream));
  std::array<NearSegment, kNear> found;
  const auto near = std::span(found).first(tree_.nearest(state, found, kind));
  const auto chosen =
      std::ranges::find_if(near, [&](const NearSegment& one) { return is_sturdy(one.segment); });
  if (chosen != near.end() && chosen->distance < reach_) return piece_of(*chosen);
  return by_graph(state, stream);
}

NextPiece NextPieces::by_graph(std::span<const double> state, Stream& stream) const {
  std::array<NearSegment, kNear> found;
  const std::size_t count = tree_.nearest(state, found);
  const NearSegment nearest = found[0];
  std::size_t choices = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (!graph_.is_kept(found[k].segment) || !is_sturdy(found[k].segment)) continue;
    if (choices > 0 && found[k].distance >= reach_) break;
    found[choices++] = found[k];
  }
  if (choices == 0) return piece_of(nearest);
  return piece_of(found[static_cast<std::size_t>(stream.uniform() * static_cast<double>(choices))]);
}

}  // namespace samara::motion
