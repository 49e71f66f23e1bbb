#include "samara/motion/planning/beam_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "samara/base/parallel.h"
#include "samara/base/shared_progress.h"
#include "samara/base/streams.h"
#include "samara/models/batch/batch_tasks.h"

namespace samara::motion {

namespace {

constexpr int kMostDecisions = 2000;
constexpr int kMostOfOneParent = 4;
/// What a change of all coefficients through their ranges costs, in semi-lengths squared times semi-lengths fallen.
constexpr double kChangeCost = 0.06;
/// What the squared deviation of the place where a fall stands counts beside the mean over its height.
constexpr double kHereCost = 0.15;
/// Of the width of a range: how far a jitter goes.
constexpr double kJitter = 0.15;
/// Constant of the Langevin equation, C_0.
constexpr double kKolmogorov = 2.1;

struct Node {
  FallPoint point;
  std::vector<double> target;  ///< of the piece that led here
  int parent = -1;             ///< in the round before
  double t_from = 0.0;         ///< when that piece began
  double change = 0.0;         ///< what changes and accelerations have cost so far
  double rank = 0.0;
};

class Beam {
 public:
  Beam(const PlannedFall& fall, const FallPoint& start)
      : fall_(fall), plan_(fall.plan()), release_height_(fall.release().height) {
    rounds_.push_back({Node{.point = start, .target = start.heading_for}});
    dissipation_ = dissipation();
  }

  BeamResult run(const ProgressCallback& progress) {
    BeamResult result;
    tbb::task_arena arena = models::arena_of(plan_.search.threads);
    while (!rounds_.back().empty() && std::ssize(rounds_) <= kMostDecisions) {
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
      note(result);
    }
    std::ranges::stable_sort(finished_, {}, &Finished::cost);
    for (const Finished& one : finished_) result.falls.push_back(found(one));
    result.lost = finished_.empty();
    return result;
  }

 private:
  struct Finished {
    int round = 0;
    int index = 0;
    double cost = 0.0;
  };

  /// k and epsilon of turbulence of the given intensity about the body.
  double dissipation() const {
    if (!(plan_.turbulence > 0.0)) return 0.0;
    const models::Scales scales = plan_.scales();
    const double k = 1.5 * std::pow(plan_.turbulence * scales.velocity, 2);
    return std::pow(0.09, 0.75) * std::pow(k, 1.5) / (0.07 * 2.0 * fall_.semi_length());
  }

  double share_done() const {
    double lowest = release_height_;
    for (const Node& node : rounds_.back()) lowest = std::min(lowest, node.point.height);
    return (release_height_ - lowest) / std::max(1e-300, release_height_ - plan_.ground);
  }

  std::vector<double> target_of(const Node& parent, std::size_t number, int child) const {
    if (child == 0) return parent.point.heading_for;
    Stream stream(plan_.search.seed,
                  (rounds_.size() << 40) + (number << 20) + static_cast<std::size_t>(child));
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

  double change_cost(const std::vector<double>& from, const std::vector<double>& to) const {
    double sum = 0.0;
    for (std::size_t j = 0; j < from.size(); ++j)
      sum += std::pow((to[j] - from[j]) / (plan_.box[j].upper - plan_.box[j].lower), 2);
    return kChangeCost * sum / static_cast<double>(from.size());
  }

  /// Per depth, in semi-lengths squared.
  double cost(const Node& node) const {
    const double a = fall_.semi_length();
    const double fallen = std::max(a, release_height_ - node.point.height) / a;
    const double t = std::max(1e-300, node.point.t);
    return node.point.square_time / t / (a * a) + node.change / fallen;
  }

  void extend(SharedProgress& progress) {
    const std::vector<Node>& parents = rounds_.back();
    const auto children = static_cast<std::size_t>(plan_.search.children);
    std::vector<Continuation> continuations(parents.size() * children);
    std::vector<FallPiece> pieces(continuations.size());
    for (std::size_t i = 0; i < parents.size(); ++i) {
      for (std::size_t c = 0; c < children; ++c) {
        continuations[i * children + c] = {.from = &parents[i].point,
                                           .target = target_of(parents[i], i, static_cast<int>(c))};
      }
    }
    pieces_ += std::ssize(continuations);
    // So many that what is left over at the end of a task is little; the same whatever the number of threads.
    constexpr std::size_t kTask = 256;
    const std::size_t tasks = (continuations.size() + kTask - 1) / kTask;
    parallel_for(tasks, [&](std::size_t task) {
      const std::size_t first = task * kTask, count = std::min(kTask, continuations.size() - first);
      FallLanes(fall_).run(std::span(continuations).subspan(first, count),
                           std::span(pieces).subspan(first, count), progress);
    });
    if (progress.cancelled()) return;
    choose(parents, continuations, pieces);
  }

  void choose(const std::vector<Node>& parents, const std::vector<Continuation>& continuations,
              std::vector<FallPiece>& pieces) {
    const auto children = static_cast<std::size_t>(plan_.search.children);
    std::vector<Node> nodes;
    std::vector<Node> ended;
    for (std::size_t n = 0; n < pieces.size(); ++n) {
      FallPiece& piece = pieces[n];
      if (piece.end == FallEnd::not_finite || !(piece.to.t > parents[n / children].point.t)) continue;
      const Node& parent = parents[n / children];
      Node node{.point = std::move(piece.to),
                .target = continuations[n].target,
                .parent = static_cast<int>(n / children),
                .t_from = parent.point.t,
                .change = parent.change + change_cost(parent.point.heading_for, continuations[n].target)};
      if (dissipation_ > 0.0) {
        const double tau = node.point.t - parent.point.t;
        node.change += piece.acceleration_square / (3.0 * kKolmogorov * dissipation_ / tau) *
                       std::abs(parent.point.height - node.point.height) / fall_.semi_length();
      }
      node.rank = cost(node) + landing_cost(node);
      if (piece.end == FallEnd::ground) {
        ended.push_back(std::move(node));
      } else {
        node.rank += kHereCost *
                     (node.point.deviation.squaredNorm() + fall_.off_course(node.point).squaredNorm()) /
                     std::pow(fall_.semi_length(), 2);
        nodes.push_back(std::move(node));
      }
    }
    keep_best(nodes);
    keep_best(ended);
    const int round = static_cast<int>(rounds_.size());
    const int first_ended = static_cast<int>(nodes.size());
    for (std::size_t k = 0; k < ended.size(); ++k)
      finished_.push_back({round, first_ended + static_cast<int>(k), ended[k].rank});
    // What has ended stands behind what goes on, and is cut off for the next round.
    ended_.resize(rounds_.size() + 1);
    ended_.back() = std::move(ended);
    rounds_.push_back(std::move(nodes));
  }

  double landing_cost(const Node& node) const {
    if (!plan_.landing || node.point.height > plan_.ground + fall_.semi_length()) return 0.0;
    const Eigen::Vector3d off = fall_.states().position(node.point.state) - *plan_.landing;
    return off.head<2>().squaredNorm() / std::pow(fall_.semi_length(), 2);
  }

  void keep_best(std::vector<Node>& nodes) const {
    std::vector<std::size_t> order(nodes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t n) { return nodes[n].rank; });
    std::vector<int> taken(rounds_.back().size(), 0);
    std::vector<Node> kept;
    for (const std::size_t n : order) {
      if (std::ssize(kept) >= plan_.search.beam) break;
      int& of_parent = taken[static_cast<std::size_t>(nodes[n].parent)];
      if (of_parent >= kMostOfOneParent && rounds_.back().size() > 1) continue;
      ++of_parent;
      kept.push_back(std::move(nodes[n]));
    }
    nodes = std::move(kept);
  }

  const Node& node(int round, int index) const {
    const auto& running = rounds_[static_cast<std::size_t>(round)];
    if (index < static_cast<int>(running.size())) return running[static_cast<std::size_t>(index)];
    return ended_[static_cast<std::size_t>(round)][static_cast<std::size_t>(index) - running.size()];
  }

  FoundFall found(const Finished& one) const {
    FoundFall fall;
    fall.cost = one.cost;
    fall.end = node(one.round, one.index).point;
    int index = one.index;
    for (int round = one.round; round > 0; --round) {
      const Node& here = node(round, index);
      fall.knots.push_back({here.t_from, here.target, plan_.search.ramp});
      index = here.parent;
    }
    std::ranges::reverse(fall.knots);
    return fall;
  }

  void note(BeamResult& result) const {
    PlanningStep step{.stage = "beam", .cost = 0.0, .depth = 0.0, .pieces = pieces_};
    const std::vector<Node>& nodes = rounds_.back();
    if (!nodes.empty()) {
      step.cost = cost(nodes.front());
      step.depth = release_height_ - nodes.front().point.height;
    } else if (!finished_.empty()) {
      const auto best = std::ranges::min_element(finished_, {}, &Finished::cost);
      step.cost = best->cost;
      step.depth = release_height_ - node(best->round, best->index).point.height;
    }
    result.history.push_back(step);
  }

  const PlannedFall& fall_;
  const MotionPlan& plan_;
  double release_height_;
  double dissipation_ = 0.0;
  std::vector<std::vector<Node>> rounds_;
  std::vector<std::vector<Node>> ended_ = std::vector<std::vector<Node>>(1);
  std::vector<Finished> finished_;
  long pieces_ = 0;
};

}  // namespace

BeamResult search_beam(const PlannedFall& fall, const FallPoint& start, const ProgressCallback& progress) {
  return Beam(fall, start).run(progress);
}

}  // namespace samara::motion
