#pragma once

#include <memory>
#include <span>
#include <vector>

#include "samara/base/streams.h"
#include "samara/motion/database/motion_graph.h"
#include "samara/motion/database/segment_tree.h"

namespace samara::motion {

/// A segment to go on with: its run's coefficients, from a state like that in which it began.
struct NextPiece {
  Eigen::Index segment = 0;
  EventKind kind = EventKind::swing_plus;
  double distance = 0.0;  ///< of the state to the segment's start
};

/// What a motion can go on with from the state that it is really in. Closed loop: nothing but states, kinds and
/// coefficients is taken from the database, and each choice is made anew at the next event. Immutable, shared between
/// threads; choices do not allocate.
class NextPieces {
 public:
  explicit NextPieces(MotionDatabase database);
  NextPieces(MotionDatabase database, MotionGraph graph);

  const MotionDatabase& database() const { return database_; }
  const MotionGraph& graph() const { return graph_; }
  const MarkovChain& chain() const { return chain_; }
  const SegmentTree& tree() const { return tree_; }
  const Eigen::VectorXd& coefficients(const NextPiece& piece) const;
  /// Median duration of the segments [s].
  double median_duration() const { return median_duration_; }

  /// The nearest segment of a kind. @throws ArgumentError if there is none of it
  NextPiece of_kind(std::span<const double> state, EventKind kind) const;

  /// Where nine of ten segments of the graph's largest component find one to go on with, in another run: how near a
  /// choice of a kind must be.
  double reach() const { return reach_; }

  /// Whether a segment keeps its kind from states that are not quite its own: with its coefficients, from the starts of
  /// the three segments that begin nearest within reach(), the next event is of its kind as well. Choices are made
  /// among such segments.
  bool is_sturdy(Eigen::Index segment) const { return sturdy_[static_cast<std::size_t>(segment)] != 0; }

  /// One of the graph's largest component, any as likely as another.
  Eigen::Index draw_segment(Stream& stream) const;

  /// What to go on with after a segment, among its edges of the graph: the sturdy ones that begin within reach() of the
  /// state that the motion is really in. anywhere() if there is none, or no segment was followed.
  /// @param followed -1: none
  NextPiece after(Eigen::Index followed, std::span<const double> state, Stream& stream) const;

  /// The same, of a kind that is drawn from the chain, if there is one.
  /// @param past kinds, the latest last
  NextPiece after(Eigen::Index followed, std::span<const double> state, std::span<const int> past,
                  Stream& stream) const;

  /// One of the four sturdy segments of the largest component that begin nearest, any within reach(); else the nearest.
  /// (With a slack of 4, see NearPoints: it takes microseconds, and keeps as many kinds.)
  NextPiece anywhere(std::span<const double> state, Stream& stream) const;

 private:
  static constexpr std::size_t kMostEdges = 32;
  NextPiece piece_of(const NearSegment& found) const;
  void try_kinds();
  SegmentTree sturdy_tree() const;
  /// Sturdy segments that the graph leads to, within reach(), the nearest first.
  std::size_t candidates(Eigen::Index followed, std::span<const double> state,
                         std::span<NearSegment> found) const;

  MotionDatabase database_;
  MotionGraph graph_;
  SegmentTree tree_;
  StateMetric metric_;
  MarkovChain chain_;
  double median_duration_ = 0.0, reach_ = 0.0;
  std::vector<char> sturdy_;
  Eigen::MatrixXd places_;                   ///< of all starts, in the metric, a column each
  std::unique_ptr<const SegmentTree> near_;  ///< of sturdy, kept ones
};

}  // namespace samara::motion
