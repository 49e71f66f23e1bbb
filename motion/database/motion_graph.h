#pragma once

#include <vector>

#include "samara/motion/database/motion_database.h"

/// What can follow what (L. Kovar, M. Gleicher, F. Pighin, Motion graphs, ACM Trans. Graph. 21, 2002): segments are
/// nodes; one leads to another if it ends within a threshold of where that begins. It gives branches to searches and
/// pieces to chains, never frames: nothing is blended over an edge.
namespace samara::motion {

struct GraphEdge {
  Eigen::Index from = 0, to = 0;
  /// Of the end of `from` and the start of `to`; 0 where one continues the other in its run.
  double distance = 0.0;
};

struct ThresholdPoint {
  double threshold = 0.0;
  double share = 0.0;  ///< of all segments, in the largest strongly connected component
  Eigen::Index edges = 0;
};

struct MotionGraph {
  /// The smallest whose share is within 1 % of the largest share of all.
  double threshold = 0.0;
  std::vector<ThresholdPoint> curve;
  std::vector<GraphEdge> edges;          ///< at the threshold, by `from`, then by distance
  std::vector<Eigen::Index> first_edge;  ///< per segment, and one more
  /// Number of the strongly connected component of each segment; 0 is the largest.
  std::vector<int> component;
  Eigen::Index kept = 0, pruned = 0;  ///< segments in the largest, and others

  bool is_kept(Eigen::Index segment) const { return component[static_cast<std::size_t>(segment)] == 0; }
};

/// Every node leads to the 16 nearest at most, two of them in one other run, and to the one that comes next in its own.
MotionGraph motion_graph(const MotionDatabase& database);

/// Components of nodes 0 to nodes - 1 (R. Tarjan, SIAM J. Comput. 1, 1972), the largest first. Not by recursion: deep
/// graphs do not overflow the stack.
/// @param first_edge per node, and one more: where its edges begin in `to`
std::vector<int> strong_components(const std::vector<Eigen::Index>& first_edge,
                                   const std::vector<Eigen::Index>& to);

}  // namespace samara::motion
