#include "samara/motion/planning/beam_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "samara/base/parallel.h"
#include "samara/base/shared_progress.h"
#include "samara/base/streams.h"
#include "samara/models/batch/batch_tasks.h"
#include "samara/motion/planning/fall_cost.h"

namespace samara::motion {

namespace {

constexpr int kMostDecisions = 2000;
constexpr int kMostOfOneParent = 4;
/// Rounds without any fall that comes a semi-length further down, after which none is going to.
constexpr int kMostRoundsAloft = 40;
/// What the squared deviation of the place where a fall stands counts beside its cost.
constexpr double kHereCost = 0.15;
/// What the outlook counts at most, twice, of a segment that is missed; from which distance on there is none.
constexpr double kOutlook = 0.4, kNear = 0.4;
constexpr std::uint64_t kOfOutlooks = 0x6f75746c6f6f6bULL;  // streams that no child draws from
/// Of the width of a range: how far a jitter goes.
constexpr double kJitter = 0.15;

class Beam {
 public:
  Beam(const PlannedFall& fall, BeamState& state) : fall_(fall), plan_(fall.plan()), state_(state) {}

  BeamResult run(const ProgressCallback& progress, const std::function<void()>& keep) {
    BeamResult result;
    tbb::task_arena arena = models::arena_of(plan_.search.threads);
    while (goes_on()) {
      // What a round reports is how far falls had come before it.
      const double done = std::min(1.0, share_done());
      const ProgressCallback round = [&](const Progress&) {
        return !progress || progress({"searching falls", done});
      };
      SharedProgress shared(round, "searching falls", 1.0);
      if (shared.goes_on()) arena.execute([&] { extend(shared); });
      if (shared.cancelled()) {
        result.cancelled = true;
        return result;
      }
      note();
      if (keep) keep();
    }
    std::vector<BeamState::Finished> finished = state_.finished;
    std::ranges::stable_sort(finished, {}, &BeamState::Finished::cost);
    for (const BeamState::Finished& one : finished) result.falls.push_back(found(one));
    if (finished.empty())
      result.lost = state_.rounds.back().empty() ? "the numbers of all were not finite"
                    : is_aloft()                 ? "none sinks any further"
                                                 : "it took too many decisions";
    return result;
  }

 private:
  bool is_aloft() const { return std::ssize(state_.rounds) - 1 - state_.sunk_in > kMostRoundsAloft; }
  bool goes_on() const {
    return !state_.rounds.back().empty() && std::ssize(state_.rounds) <= kMostDecisions && !is_aloft();
  }

  double share_done() const {
    double lowest = fall_.release_height();
    for (const BeamNode& node : state_.rounds.back()) lowest = std::min(lowest, node.point.height);
    return (fall_.release_height() - lowest) / std::max(1e-300, fall_.release_height() - plan_.ground);
  }

  /// By turns a jitter, a proposal of the database, and any values at all; the last in place of proposals that there
  /// are none of.
  /// @param proposed coefficients that the database proposes from here
  std::vector<double> target_of(const BeamNode& parent, std::size_t number, int child,
                                std::span<const std::vector<double>> proposed) const {
    if (child == 0) return parent.point.heading_for;
    const auto proposal = static_cast<std::size_t>(child / 3);
    if (child % 3 == 2 && proposal < proposed.size()) return proposed[proposal];
    Stream stream(plan_.search.seed,
                  (state_.rounds.size() << 40) + (number << 20) + static_cast<std::size_t>(child));
    std::vector<double> target = parent.point.heading_for;
    const bool jitters = child % 3 == 1;
    for (std::size_t j = 0; j < target.size(); ++j) {
      const SteeredCoefficient& range = plan_.box[j];
      const double width = range.upper - range.lower;
      target[j] = jitters
                      ? std::clamp(target[j] + kJitter * width * stream.normal(), range.lower, range.upper)
                      : range.lower + width * stream.uniform();
    }
    return target;
  }

  std::vector<std::vector<double>> proposals(const BeamNode& parent) const {
    const auto& choices = fall_.choices();
    if (!choices) return {};
    std::vector<std::vector<double>> all(static_cast<std::size_t>(plan_.search.children / 3),
                                         parent.point.heading_for);
    all.resize(choices->propose(parent.point.state, fall_.asked(parent.point), all));
    return all;
  }

  void extend(SharedProgress& progress) {
    const std::vector<BeamNode>& parents = state_.rounds.back();
    const auto children = static_cast<std::size_t>(plan_.search.children);
    std::vector<Continuation> continuations(parents.size() * children);
    std::vector<FallPiece> pieces(continuations.size());
    for (std::size_t i = 0; i < parents.size(); ++i) {
      const std::vector<std::vector<double>> proposed = proposals(parents[i]);
      for (std::size_t c = 0; c < children; ++c) {
        continuations[i * children + c] = {.from = &parents[i].point,
                                           .target = target_of(parents[i], i, static_cast<int>(c), proposed)};
      }
    }
    // So many that what is left over at the end of a task is little; the same whatever the number of threads.
    constexpr std::size_t kTask = 256;
    const std::size_t tasks = (continuations.size() + kTask - 1) / kTask;
    parallel_for(tasks, [&](std::size_t task) {
      const std::size_t first = task * kTask, count = std::min(kTask, continuations.size() - first);
      FallLanes(fall_).run(std::span(continuations).subspan(first, count),
                           std::span(pieces).subspan(first, count), progress);
    });
    if (progress.cancelled()) return;
    state_.pieces += std::ssize(continuations);
    choose(parents, continuations, pieces);
  }

  /// Of falls that have had what was asked so far, which one can have what comes: falls that stand where the database
  /// has segments of that kind are better off; and a draw among equals, or all that are kept would be one fall that
  /// changes nothing. Less than a segment that is missed.
  double outlook(const FallPoint& point, std::uint64_t number) const {
    const AskedSegment* asked = fall_.asked(point);
    if (asked == nullptr || !asked->kind) return 0.0;
    const double miss = plan_.sequence->weight / static_cast<double>(plan_.sequence->segments.size());
    double outlook = Stream(plan_.search.seed ^ kOfOutlooks, number).uniform();
    if (fall_.choices()) outlook += std::min(1.0, fall_.choices()->distance(point.state, *asked) / kNear);
    return kOutlook * miss * outlook;
  }

  BeamNode node_of(const BeamNode& parent, int number, const Continuation& continuation, FallPiece& piece,
                   std::uint64_t stream_number) const {
    const FallPoint& from = parent.point;
    BeamNode node{
        .point = std::move(piece.to), .target = continuation.target, .parent = number, .t_from = from.t};
    FallPoint& to = node.point;
    to.changes = from.changes;
    to.turbulence = from.turbulence;
    to.kinds = from.kinds;
    to.events = from.events;
    to.past = from.past;
    add_change(fall_, to, from.heading_for, continuation.target);
    add_piece(fall_, to, to.t - from.t, from.height - to.height);
    if (piece.has_event) add_event(fall_, to, piece.kind);
    node.rank = cost_of(fall_, to).total();
    if (piece.end == FallEnd::ground) return node;
    node.rank += outlook(to, stream_number);
    node.rank += kHereCost * (to.deviation.squaredNorm() + fall_.off_course(to).squaredNorm()) /
                 std::pow(fall_.semi_length(), 2);
    return node;
  }

  void choose(const std::vector<BeamNode>& parents, const std::vector<Continuation>& continuations,
              std::vector<FallPiece>& pieces) {
    const auto children = static_cast<std::size_t>(plan_.search.children);
    std::vector<BeamNode> nodes;
    std::vector<BeamNode> ended;
    for (std::size_t n = 0; n < pieces.size(); ++n) {
      FallPiece& piece = pieces[n];
      const std::size_t parent = n / children;
      if (piece.end == FallEnd::not_finite || !(piece.to.t > parents[parent].point.t)) continue;
      const bool has_ended = piece.end == FallEnd::ground;
      (has_ended ? ended : nodes)
          .push_back(node_of(parents[parent], static_cast<int>(parent), continuations[n], piece,
                             (state_.rounds.size() << 40) + n));
    }
    keep_best(nodes);
    keep_best(ended);
    const int round = static_cast<int>(state_.rounds.size());
    const int first_ended = static_cast<int>(nodes.size());
    for (std::size_t k = 0; k < ended.size(); ++k)
      state_.finished.push_back({round, first_ended + static_cast<int>(k), ended[k].rank});
    for (const BeamNode& node : nodes) {
      if (node.point.height > state_.lowest - fall_.semi_length()) continue;
      state_.lowest = node.point.height;
      state_.sunk_in = round;
    }
    // What has ended stands after what goes on, and is cut off for the next round.
    state_.ended.resize(state_.rounds.size() + 1);
    state_.ended.back() = std::move(ended);
    state_.rounds.push_back(std::move(nodes));
  }

  void keep_best(std::vector<BeamNode>& nodes) const {
    std::vector<std::size_t> order(nodes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t n) { return nodes[n].rank; });
    std::vector<int> taken(state_.rounds.back().size(), 0);
    std::vector<BeamNode> kept;
    for (const std::size_t n : order) {
      if (std::ssize(kept) >= plan_.search.beam) break;
      int& of_parent = taken[static_cast<std::size_t>(nodes[n].parent)];
      if (of_parent >= kMostOfOneParent && state_.rounds.back().size() > 1) continue;
      ++of_parent;
      kept.push_back(std::move(nodes[n]));
    }
    nodes = std::move(kept);
  }

  const BeamNode& node(int round, int index) const {
    const auto& running = state_.rounds[static_cast<std::size_t>(round)];
    if (index < static_cast<int>(running.size())) return running[static_cast<std::size_t>(index)];
    return state_.ended[static_cast<std::size_t>(round)][static_cast<std::size_t>(index) - running.size()];
  }

  FoundFall found(const BeamState::Finished& one) const {
    FoundFall fall;
    fall.cost = one.cost;
    fall.end = node(one.round, one.index).point;
    int index = one.index;
    for (int round = one.round; round > 0; --round) {
      const BeamNode& here = node(round, index);
      fall.knots.push_back({here.t_from, here.target, plan_.search.ramp});
      index = here.parent;
    }
    std::ranges::reverse(fall.knots);
    return fall;
  }

  void note() {
    PlanningStep step{.stage = "beam", .pieces = state_.pieces};
    const std::vector<BeamNode>& nodes = state_.rounds.back();
    const FallPoint* best = nodes.empty() ? nullptr : &nodes.front().point;
    if (nodes.empty() && !state_.finished.empty()) {
      const auto one = std::ranges::min_element(state_.finished, {}, &BeamState::Finished::cost);
      best = &node(one->round, one->index).point;
    }
    if (best != nullptr) {
      step.cost = cost_of(fall_, *best).total();
      step.depth = fall_.release_height() - best->height;
    }
    state_.history.push_back(step);
  }

  const PlannedFall& fall_;
  const MotionPlan& plan_;
  BeamState& state_;
};

}  // namespace

BeamState BeamState::from(const FallPoint& start) {
  BeamState state;
  state.rounds.push_back({BeamNode{.point = start, .target = start.heading_for}});
  state.ended.resize(1);
  state.lowest = start.height;
  return state;
}

BeamResult search_beam(const PlannedFall& fall, BeamState& state, const ProgressCallback& progress,
                       const std::function<void()>& keep) {
  return Beam(fall, state).run(progress, keep);
}

}  // namespace samara::motion
