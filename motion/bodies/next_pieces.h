#pragma once

#include <array>
#include <memory>
#include <optional>
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
  /// The kind that a chain drew at first; another one than `kind` where no piece of it is to be had.
  std::optional<EventKind> drawn = {};
  bool is_of_chain = false;  ///< its kind was drawn, at first or among those that were left
};

struct PieceOptions {
  /// s, in which coefficients change when pieces are tried; below 0: a quarter of the median segment.
  double ramp = -1.0;
};

/// What a motion can go on with from the state that it is really in. Closed loop: nothing but states, kinds and
/// coefficients is taken from the database, and each choice is made anew at the next event. Immutable, shared between
/// threads; choices do not allocate.
///
/// Pieces are tried beforehand, the way bodies go on with them: every edge of the graph within reach(), from the end of
/// its segment with the coefficients of that until the event is certain, then on the ramp. An edge is *sound* if the
/// next event is of the kind of the segment that it leads to; a segment is *reliable* if nine of ten edges that lead to
/// it from other runs are, one at least. Choices are made among sound edges and reliable segments.
class NextPieces {
 public:
  explicit NextPieces(MotionDatabase database, const PieceOptions& options = {});

  const MotionDatabase& database() const { return database_; }
  const MotionGraph& graph() const { return graph_; }
  const MarkovChain& chain() const { return chain_; }
  const SegmentTree& tree() const { return tree_; }
  const Eigen::VectorXd& coefficients(const NextPiece& piece) const;
  /// s, with which pieces were tried.
  double ramp() const { return ramp_; }

  /// The 90 % point, over segments of the graph's largest component that have an edge into another run, of the distance
  /// to the nearest: how near a choice must be.
  double reach() const { return reach_; }

  bool is_sturdy(Eigen::Index segment) const { return sturdy_[static_cast<std::size_t>(segment)] != 0; }
  /// Reliable segments of the largest component, and how many edges were tried and found sound.
  Eigen::Index sturdy_count() const { return sturdy_count_; }
  Eigen::Index tried() const { return tried_; }
  Eigen::Index sound() const { return sound_count_; }

  /// One of the graph's largest component, any as likely as another.
  Eigen::Index draw_segment(Stream& stream) const;

  /// What to go on with after a segment from the state that the motion is really in, the best first: along its sound
  /// edges, those that begin within reach(), one of them first by chance; then of the reliable segments that begin
  /// nearest one within reach() by chance, and the others; at last the nearest reliable one of each kind, for which
  /// places are kept. With the chain: at first the nearest along an edge of a kind that it draws, then the nearest
  /// reliable ones of that kind within reach(); then likewise of a kind that it draws among those that are left, and so
  /// on: the first of them is drawn from the chain among the kinds that are to be had here. Only then any, as above.
  /// @param followed -1: none
  /// @param found as many as are wanted, kMost at most  @returns how many there are, at least one
  std::size_t after(Eigen::Index followed, std::span<const double> state, Stream& stream,
                    std::span<NextPiece> found) const;
  /// @param past kinds, the latest last
  std::size_t after(Eigen::Index followed, std::span<const double> state, std::span<const int> past,
                    Stream& stream, std::span<NextPiece> found) const;

  static constexpr std::size_t kMost = 8;

 private:
  static constexpr std::size_t kMostEdges = 32;
  class Found;
  class Nearest;
  void try_edges();
  void plant_trees();
  using Places = SegmentTree::Places;
  /// Segments along sound edges, within reach(), the nearest first.
  std::size_t candidates(Eigen::Index followed, const Places& places, std::span<NearSegment> found) const;
  Nearest nearest_of(const Places& places, std::span<const NearSegment> along) const;
  void add_of_kind(EventKind kind, Nearest& nearest, std::span<const NearSegment> along, Found& found) const;
  void add_near(Nearest& nearest, Stream& stream, Found& found) const;
  void add_any(Nearest& nearest, std::span<const NearSegment> along, Stream& stream, Found& found) const;

  MotionDatabase database_;
  MotionGraph graph_;
  SegmentTree tree_;
  StateMetric metric_;
  MarkovChain chain_;
  double ramp_ = 0.0, reach_ = 0.0;
  std::vector<char> sound_;   ///< per edge
  std::vector<char> sturdy_;  ///< per segment
  Eigen::Index sturdy_count_ = 0, tried_ = 0, sound_count_ = 0;
  Eigen::MatrixXd places_;                   ///< of all starts, in the metric, a column each
  std::unique_ptr<const SegmentTree> near_;  ///< of reliable ones
  /// Of these, by kind; none: there are none.
  std::array<std::unique_ptr<const SegmentTree>, kEventKinds> kinds_;
};

}  // namespace samara::motion
