#include "samara/motion/bodies/next_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/motion/bodies/piece_trials.h"

namespace samara::motion {

namespace {

/// Of the edges that lead to a reliable segment, the share that must be sound.
constexpr double kSturdy = 0.9;
/// Of reliable segments near a state, how many are looked for.
constexpr std::size_t kNear = 4;

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

/// Of some of their coordinates.
double square_between(const double* a, const double* b, std::size_t first, std::size_t last) {
  double sum = 0.0;
  for (std::size_t i = first; i < last; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

double median_duration(const MotionDatabase& database) {
  std::vector<double> durations;
  for (const MotionSegment& segment : database.segments) durations.push_back(segment.duration);
  const auto middle = durations.begin() + static_cast<std::ptrdiff_t>(durations.size() / 2);
  std::ranges::nth_element(durations, middle);
  return *middle;
}

}  // namespace

NextPieces::NextPieces(MotionDatabase database, const PieceOptions& options)
    : database_(std::move(database)),
      graph_(motion_graph(database_)),
      tree_(database_),
      metric_(database_.metric()),
      chain_(kind_chain(database_).chain),
      ramp_(options.ramp < 0.0 ? 0.25 * median_duration(database_) : options.ramp),
      reach_(reach_of(graph_)) {
  if (!std::isfinite(ramp_))
    throw ArgumentError(fmt::format("the ramp of pieces is {}, expected a finite time", ramp_));
  const MovingStates& moving = tree_.moving_states();
  places_.resize(moving.reduced_size(), database_.segment_count());
  Eigen::VectorXd state;
  for (Eigen::Index n = 0; n < database_.segment_count(); ++n) {
    state = database_.starts.row(n);
    const std::span<double> place(places_.col(n).data(), static_cast<std::size_t>(places_.rows()));
    moving.reduce({state.data(), static_cast<std::size_t>(state.size())}, place);
    metric_.place(place);
  }
  try_edges();
  plant_trees();
}

const Eigen::VectorXd& NextPieces::coefficients(const NextPiece& piece) const {
  const MotionSegment& segment = database_.segments[static_cast<std::size_t>(piece.segment)];
  return database_.runs[static_cast<std::size_t>(segment.run)].coefficients;
}

void NextPieces::try_edges() {
  const auto tries = [&](const GraphEdge& edge) {
    return graph_.is_kept(edge.from) && graph_.is_kept(edge.to) && edge.distance < reach_;
  };
  std::vector<PieceTrial> trials;
  for (const GraphEdge& edge : graph_.edges) {
    if (tries(edge)) trials.push_back({.after = edge.from, .with = edge.to});
  }
  const std::vector<char> kept = try_pieces(database_, trials, ramp_);
  sound_.assign(graph_.edges.size(), 0);
  std::vector<double> into(database_.segments.size(), 0.0), sound_into(into);
  std::size_t trial = 0;
  for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
    if (!tries(graph_.edges[k])) continue;
    const auto to = static_cast<std::size_t>(graph_.edges[k].to);
    sound_[k] = kept[trial++];
    if (graph_.edges[k].distance == 0.0) continue;  // its own run
    into[to] += 1.0;
    sound_into[to] += sound_[k];
  }
  tried_ = std::ssize(trials);
  sound_count_ = std::ranges::count(sound_, 1);
  sturdy_.assign(into.size(), 0);
  for (std::size_t n = 0; n < into.size(); ++n)
    sturdy_[n] = into[n] > 0.0 && sound_into[n] >= kSturdy * into[n] ? 1 : 0;
  sturdy_count_ = std::ranges::count(sturdy_, 1);
}

Eigen::Index NextPieces::draw_segment(Stream& stream) const {
  auto pick = static_cast<Eigen::Index>(stream.uniform() * static_cast<double>(graph_.kept));
  Eigen::Index segment = 0;
  for (; segment + 1 < database_.segment_count(); ++segment) {
    if (graph_.is_kept(segment) && pick-- == 0) break;
  }
  return segment;
}

void NextPieces::plant_trees() {
  std::vector<Eigen::Index> chosen;
  std::array<std::vector<Eigen::Index>, kEventKinds> of_kinds;
  for (Eigen::Index n = 0; n < database_.segment_count(); ++n) {
    if (!graph_.is_kept(n) || (sturdy_count_ > 0 && !is_sturdy(n))) continue;
    chosen.push_back(n);
    of_kinds[static_cast<std::size_t>(database_.segments[static_cast<std::size_t>(n)].kind)].push_back(n);
  }
  near_ = std::make_unique<SegmentTree>(database_, std::move(chosen));
  for (std::size_t kind = 0; kind < kEventKinds; ++kind) {
    if (!of_kinds[kind].empty())
      kinds_[kind] = std::make_unique<SegmentTree>(database_, std::move(of_kinds[kind]));
  }
}

std::size_t NextPieces::candidates(Eigen::Index followed, const Places& places,
                                   std::span<NearSegment> found) const {
  if (followed < 0) return 0;
  std::size_t have = 0;
  const auto node = static_cast<std::size_t>(followed);
  for (Eigen::Index k = graph_.first_edge[node]; k < graph_.first_edge[node + 1] && have < found.size();
       ++k) {
    if (sound_[static_cast<std::size_t>(k)] == 0) continue;
    const Eigen::Index to = graph_.edges[static_cast<std::size_t>(k)].to;
    double least = reach_ * reach_;
    const double* start = places_.data() + static_cast<std::size_t>(to) * places.dimensions;
    for (std::size_t copy = 0; copy < places.copies; ++copy) {
      const double* place = places.copy(copy).data();
      // The first three tell most copies apart.
      double square = square_between(place, start, 0, 3);
      if (square < least) square += square_between(place, start, 3, places.dimensions);
      least = std::min(least, square);
    }
    if (least < reach_ * reach_) found[have++] = {to, std::sqrt(least)};
  }
  std::ranges::sort(found.first(have), {}, &NearSegment::distance);
  return have;
}

/// The reliable segment that begins nearest to a state, looked for once, and only where it is asked for.
class NextPieces::Nearest {
 public:
  Nearest(const SegmentTree& tree, const Places& places) : tree_(tree), places_(places) {}

  const Places& places() const { return places_; }
  /// One that is known to be reliable, and near: others are looked for where they are nearer.
  void try_first(const NearSegment& near) { nearest_ = near; }
  const NearSegment* of_all() {
    if (!is_known_) {
      NearSegment near;
      if (tree_.nearest(places_, {&near, 1}, nearest_.distance) > 0) nearest_ = near;
    }
    is_known_ = true;
    return std::isfinite(nearest_.distance) ? &nearest_ : nullptr;
  }

 private:
  const SegmentTree& tree_;
  const Places& places_;
  NearSegment nearest_ = {.distance = std::numeric_limits<double>::infinity()};
  bool is_known_ = false;
};

NextPieces::Nearest NextPieces::nearest_of(const Places& places, std::span<const NearSegment> along) const {
  Nearest nearest(*near_, places);
  const auto sturdy =
      std::ranges::find_if(along, [&](const NearSegment& one) { return is_sturdy(one.segment); });
  if (sturdy != along.end()) nearest.try_first(*sturdy);
  return nearest;
}

/// Pieces that are found, each segment once, until there are enough.
class NextPieces::Found {
 public:
  Found(const MotionDatabase& database, std::span<NextPiece> room)
      : database_(database),
        room_(room),
        limit_(std::max(std::size_t{1}, room.size() - std::min(room.size(), kEventKinds))) {}

  /// Places are kept for one of each kind, if there is room.
  void open_all() {
    limit_ = room_.size();
    is_of_chain_ = false;
  }
  /// What is added now is of a kind that the chain drew.
  /// @param is_first of those of this event; of others there is place for one
  void draw(EventKind kind, bool is_first) {
    is_of_chain_ = true;
    if (is_first) {
      drawn_ = kind;
    } else {
      limit_ = std::min(count_ + 1, room_.size());
    }
  }
  bool is_full() const { return count_ >= limit_; }
  bool has_room() const { return count_ < room_.size(); }
  /// How many can still be added.
  std::size_t room() const { return limit_ - std::min(limit_, count_); }
  std::size_t count() const { return count_; }
  EventKind kind_of(const NearSegment& near) const {
    return database_.segments[static_cast<std::size_t>(near.segment)].kind;
  }
  void add(const NearSegment& near) {
    const auto known = room_.first(count_);
    if (is_full() || std::ranges::find(known, near.segment, &NextPiece::segment) != known.end()) return;
    room_[count_++] = {near.segment, kind_of(near), near.distance, drawn_, is_of_chain_};
  }
  /// From one of them on that chance takes, and round.
  void add_by_chance(std::span<const NearSegment> some, Stream& stream) {
    if (is_full() || some.empty()) return;
    const auto first = static_cast<std::size_t>(stream.uniform() * static_cast<double>(some.size()));
    for (std::size_t k = 0; k < some.size(); ++k) add(some[(first + k) % some.size()]);
  }

 private:
  const MotionDatabase& database_;
  std::span<NextPiece> room_;
  std::optional<EventKind> drawn_;
  bool is_of_chain_ = false;
  std::size_t limit_, count_ = 0;
};

void NextPieces::add_any(Nearest& nearest, std::span<const NearSegment> along, Stream& stream,
                         Found& found) const {
  found.add_by_chance(along, stream);
  if (!found.is_full()) add_near(nearest, stream, found);
  found.open_all();
  NearSegment near;
  for (std::size_t kind = 0; kind < kEventKinds && !found.is_full(); ++kind) {
    if (kinds_[kind] && kinds_[kind]->nearest(nearest.places(), {&near, 1}) > 0) found.add(near);
  }
}

void NextPieces::add_near(Nearest& nearest, Stream& stream, Found& found) const {
  const NearSegment* const first = nearest.of_all();
  if (first == nullptr) return;
  if (found.room() == 1 && first->distance >= reach_) return found.add(*first);
  std::array<NearSegment, kNear> near;
  const auto all = std::span<const NearSegment>(near).first(near_->nearest(nearest.places(), near));
  const auto far = std::ranges::find_if(all, [&](const NearSegment& one) { return one.distance >= reach_; });
  const auto inside = static_cast<std::size_t>(far - all.begin());
  found.add_by_chance(all.first(inside), stream);
  for (const NearSegment& one : all.subspan(inside)) found.add(one);
}

std::size_t NextPieces::after(Eigen::Index followed, std::span<const double> state, Stream& stream,
                              std::span<NextPiece> room) const {
  const Places places = tree_.places(state);
  std::array<NearSegment, kMostEdges> along;
  const std::span<const NearSegment> edges = std::span(along).first(candidates(followed, places, along));
  Nearest nearest = nearest_of(places, edges);
  Found found(database_, room);
  add_any(nearest, edges, stream, found);
  return found.count();
}

void NextPieces::add_of_kind(EventKind kind, Nearest& nearest, std::span<const NearSegment> along,
                             Found& found) const {
  for (const NearSegment& one : along) {
    if (found.kind_of(one) == kind) found.add(one);
  }
  const auto& tree = kinds_[static_cast<std::size_t>(kind)];
  if (!tree || found.is_full()) return;
  // The nearest of all is mostly of the kind, or there is none within reach.
  const NearSegment* const first = nearest.of_all();
  if (first == nullptr || first->distance >= reach_) return;
  if (found.kind_of(*first) == kind) found.add(*first);
  if (found.is_full()) return;
  // Those that are found already may be among the nearest.
  std::array<NearSegment, kNear> near;
  const std::size_t wanted = std::min(kNear, found.room() + found.count());
  const std::size_t count = tree->nearest(nearest.places(), std::span(near).first(wanted), reach_);
  for (const NearSegment& one : std::span(near).first(count)) found.add(one);
}

std::size_t NextPieces::after(Eigen::Index followed, std::span<const double> state, std::span<const int> past,
                              Stream& stream, std::span<NextPiece> room) const {
  const Places places = tree_.places(state);
  std::array<NearSegment, kMostEdges> along;
  const std::span<const NearSegment> edges = std::span(along).first(candidates(followed, places, along));
  Nearest nearest = nearest_of(places, edges);
  Found found(database_, room);
  std::array<char, kEventKinds> is_drawn = {};
  for (std::size_t n = 0; n < kEventKinds && found.has_room(); ++n) {
    const int kind = chain_.draw(past, is_drawn, stream);
    is_drawn[static_cast<std::size_t>(kind)] = 1;
    found.draw(static_cast<EventKind>(kind), n == 0);
    add_of_kind(static_cast<EventKind>(kind), nearest, edges, found);
  }
  if (!found.has_room()) return found.count();
  found.open_all();
  add_any(nearest, edges, stream, found);
  return found.count();
}

}  // namespace samara::motion
