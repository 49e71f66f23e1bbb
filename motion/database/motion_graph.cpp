#include "samara/motion/database/motion_graph.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "samara/base/parallel.h"
#include "samara/motion/search/near_points.h"

namespace samara::motion {

namespace {

/// That are tried, increasing.
constexpr std::array kThresholds = {0.0125, 0.025, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6};
/// Of a node, the nearest.
constexpr int kMostEdges = 16;
/// Of these into one other run; into its own a node has none but the one that comes next.
constexpr int kMostOfRun = 2;
/// Of the largest share: what the share at the threshold may lack of it.
constexpr double kPlateau = 0.01;

/// Starts of all segments and of their symmetric copies.
class Starts {
 public:
  explicit Starts(const MotionDatabase& database)
      : database_(database),
        moving_(database.moving_states()),
        metric_(database.metric()),
        points_(places()) {}

  /// Edges of one node below the last threshold, by distance.
  std::vector<GraphEdge> edges_from(Eigen::Index n) const {
    std::vector<GraphEdge> edges;
    const Eigen::VectorXd place = place_of(database_.ends.row(n), 0);
    // Wider and wider, until there are enough.
    for (const double threshold : kThresholds) {
      edges = edges_within(n, place, threshold);
      if (std::ssize(edges) >= kMostEdges) break;
    }
    if (std::ssize(edges) > kMostEdges) edges.resize(static_cast<std::size_t>(kMostEdges));
    const Eigen::Index next = database_.next_of(n);
    if (next >= 0) edges.insert(edges.begin(), {n, next, 0.0});
    return edges;
  }

 private:
  Eigen::Index run_of(Eigen::Index segment) const {
    return database_.segments[static_cast<std::size_t>(segment)].run;
  }

  Eigen::VectorXd place_of(const Eigen::VectorXd& state, int copy) const {
    Eigen::VectorXd place(moving_.reduced_size());
    const std::span<double> numbers(place.data(), static_cast<std::size_t>(place.size()));
    moving_.reduce({state.data(), static_cast<std::size_t>(state.size())}, numbers);
    if (copy > 0) moving_.turn_to_copy(copy, numbers);
    metric_.place(numbers);
    return place;
  }

  Eigen::MatrixXd places() {
    places_.resize(database_.segment_count() * moving_.copies(), moving_.reduced_size());
    for (Eigen::Index p = 0; p < places_.rows(); ++p)
      places_.row(p) =
          place_of(database_.starts.row(p / moving_.copies()), static_cast<int>(p % moving_.copies()));
    return places_;
  }

  /// Of other runs, the nearest of each. A periodic motion begins again and again as it did: with more of a run,
  /// or with the own one, there would be no room for others, the less the longer runs are.
  std::vector<GraphEdge> edges_within(Eigen::Index n, const Eigen::VectorXd& place, double threshold) const {
    std::vector<GraphEdge> near;
    for (const Eigen::Index p :
         points_.within({place.data(), static_cast<std::size_t>(place.size())}, threshold * threshold)) {
      const Eigen::Index to = p / moving_.copies();
      if (run_of(to) != run_of(n)) near.push_back({n, to, (places_.row(p).transpose() - place).norm()});
    }
    std::ranges::sort(near, {}, [](const GraphEdge& e) { return std::pair(e.distance, e.to); });
    std::vector<GraphEdge> edges;
    for (const GraphEdge& edge : near) {
      const auto same_run = [&](const GraphEdge& e) { return run_of(e.to) == run_of(edge.to); };
      const auto same = [&](const GraphEdge& e) { return e.to == edge.to; };
      if (std::ranges::any_of(edges, same) || std::ranges::count_if(edges, same_run) >= kMostOfRun) continue;
      edges.push_back(edge);
      if (std::ssize(edges) == kMostEdges) break;
    }
    return edges;
  }

  const MotionDatabase& database_;
  MovingStates moving_;
  StateMetric metric_;
  Eigen::MatrixXd places_;  // a copy a row, segment by segment
  NearPoints points_;
};

/// All of them, by node.
std::vector<GraphEdge> near_edges(const MotionDatabase& database) {
  const Starts starts(database);
  std::vector<std::vector<GraphEdge>> of_nodes(database.segments.size());
  parallel_for(database.segment_count(),
               [&](Eigen::Index n) { of_nodes[static_cast<std::size_t>(n)] = starts.edges_from(n); });
  std::vector<GraphEdge> edges;
  for (const auto& some : of_nodes) edges.insert(edges.end(), some.begin(), some.end());
  return edges;
}

struct Links {
  std::vector<Eigen::Index> first, to;
};

Links links_of(const std::vector<GraphEdge>& edges, Eigen::Index nodes) {
  Links links;
  links.first.assign(static_cast<std::size_t>(nodes) + 1, 0);
  for (const GraphEdge& edge : edges) {
    ++links.first[static_cast<std::size_t>(edge.from) + 1];
    links.to.push_back(edge.to);
  }
  std::partial_sum(links.first.begin(), links.first.end(), links.first.begin());
  return links;
}

/// Tarjan's walk with its own stack.
class ComponentWalk {
 public:
  ComponentWalk(const std::vector<Eigen::Index>& first, const std::vector<Eigen::Index>& to)
      : first_(first),
        to_(to),
        index_(first.size() - 1, kNew),
        low_(index_.size(), 0),
        next_(index_.size(), 0) {
    component.assign(index_.size(), kNew);
    for (std::size_t root = 0; root < index_.size(); ++root) {
      if (index_[root] == kNew) walk(root);
    }
  }

  std::vector<int> component;
  int count = 0;

 private:
  static constexpr int kNew = -1;

  void enter(std::size_t node) {
    index_[node] = low_[node] = visited_++;
    next_[node] = first_[node];
    open_.push_back(node);
    path_.push_back(node);
  }

  void walk(std::size_t root) {
    enter(root);
    while (!path_.empty()) {
      const std::size_t node = path_.back();
      if (next_[node] < first_[node + 1]) {
        const auto other = static_cast<std::size_t>(to_[static_cast<std::size_t>(next_[node]++)]);
        if (index_[other] == kNew) {
          enter(other);
        } else if (component[other] == kNew) {
          low_[node] = std::min(low_[node], index_[other]);
        }
        continue;
      }
      path_.pop_back();
      if (!path_.empty()) low_[path_.back()] = std::min(low_[path_.back()], low_[node]);
      if (low_[node] == index_[node]) close(node);
    }
  }

  void close(std::size_t root) {
    for (std::size_t node = open_.size();;) {
      node = open_.back();
      open_.pop_back();
      component[node] = count;
      if (node == root) break;
    }
    ++count;
  }

  const std::vector<Eigen::Index>&first_, &to_;
  std::vector<int> index_, low_;
  std::vector<Eigen::Index> next_;
  std::vector<std::size_t> open_, path_;
  int visited_ = 0;
};

}  // namespace

std::vector<int> strong_components(const std::vector<Eigen::Index>& first_edge,
                                   const std::vector<Eigen::Index>& to) {
  const ComponentWalk walk(first_edge, to);
  std::vector<int> sizes(static_cast<std::size_t>(walk.count), 0), order(sizes.size()), rank(sizes.size());
  for (const int c : walk.component) ++sizes[static_cast<std::size_t>(c)];
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::greater(), [&](int c) { return sizes[static_cast<std::size_t>(c)]; });
  for (std::size_t k = 0; k < order.size(); ++k)
    rank[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  std::vector<int> component = walk.component;
  for (int& c : component) c = rank[static_cast<std::size_t>(c)];
  return component;
}

MotionGraph motion_graph(const MotionDatabase& database) {
  const std::vector<GraphEdge> all = near_edges(database);
  const Eigen::Index nodes = database.segment_count();
  const auto below = [&](double threshold) {
    std::vector<GraphEdge> edges;
    std::ranges::copy_if(all, std::back_inserter(edges),
                         [&](const GraphEdge& e) { return e.distance < threshold; });
    return edges;
  };
  MotionGraph graph;
  double most = 0.0;
  for (const double threshold : kThresholds) {
    const std::vector<GraphEdge> edges = below(threshold);
    const Links links = links_of(edges, nodes);
    const std::vector<int> component = strong_components(links.first, links.to);
    const double share = static_cast<double>(std::ranges::count(component, 0)) / static_cast<double>(nodes);
    graph.curve.push_back({threshold, share, static_cast<Eigen::Index>(edges.size())});
    most = std::max(most, share);
  }
  const auto chosen = std::ranges::find_if(
      graph.curve, [&](const ThresholdPoint& point) { return point.share >= (1.0 - kPlateau) * most; });
  graph.threshold = chosen->threshold;
  graph.edges = below(graph.threshold);
  const Links links = links_of(graph.edges, nodes);
  graph.first_edge = links.first;
  graph.component = strong_components(links.first, links.to);
  graph.kept = std::ranges::count(graph.component, 0);
  graph.pruned = nodes - graph.kept;
  return graph;
}

}  // namespace samara::motion
