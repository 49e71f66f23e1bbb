#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/motion/chains/markov_chain.h"
#include "samara/motion/events/event_finder.h"
#include "samara/motion/patterns/pattern_rules.h"
#include "samara/motion/sweeps/sweep.h"

/// Motions as a store to go on from: runs of a model with their coefficients, cut at events into segments.
///
///   const MotionDatabase motions = build_database(load_sweep("card.h5"));
///   const SegmentTree tree(motions);                       // segment_tree.h: which one begins as a body moves now
///   const MotionGraph graph = motion_graph(motions);       // motion_graph.h: what can follow what
///
/// It holds states, kinds and coefficients, never frames to be played: what goes on from a segment is a solution of
/// the model with its coefficients (dissertation, sections 3.3 and 3.4, with forces in place of formulas).
namespace samara::motion {

/// One fall, with constant coefficients.
struct MotionRun {
  Eigen::Index fall = 0;         ///< of the sweep
  Eigen::VectorXd coefficients;  ///< in the order of MotionDatabase::coefficient_names
  Pattern pattern = Pattern::unresolved;
  double settle = 0.0;  ///< s that chains leave out
};

/// Between two events of a run.
struct MotionSegment {
  Eigen::Index run = 0;
  Eigen::Index first = 0, last = 0;  ///< frames of the run, each the last before the event
  EventKind kind = EventKind::swing_plus;
  double begin = 0.0, duration = 0.0;  ///< s
  /// In horizontal axes of which x lies along the horizontal velocity at its start, m; planar: (x, 0, z) of the world.
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
  bool is_steady = false;  ///< as Event::is_steady; no part of chains
};

struct MotionDatabase {
  std::string model;
  std::map<std::string, double> fixed;  ///< of all runs, SI
  std::vector<std::string> coefficient_names, coefficient_units;
  /// Of the box of coefficients, which may be none: all runs have those in `fixed`.
  Eigen::VectorXd lower, upper;
  std::string plan_text;  ///< of the sweep; empty if it came from none
  std::vector<std::string> state_names;
  double step = 0.0;            ///< s, of the integration
  double frame_interval = 0.0;  ///< s
  double settle = 0.0;          ///< s of a whole fall that chains leave out, see MotionRun::settle
  double body_length = 0.0;     ///< m
  BodySymmetry symmetry = BodySymmetry::none;  ///< that all runs have
  EventOptions events;
  Eigen::VectorXd metric_weights;

  std::vector<MotionRun> runs;
  std::vector<MotionSegment> segments;  ///< run after run, in the order of time
  Eigen::MatrixXd starts, ends;         ///< states, a segment a row
  /// Frames of all runs, a row each, and where those of each run begin; none unless the sweep keeps trajectories.
  Eigen::MatrixXd frames;
  std::vector<Eigen::Index> run_first;

  Eigen::Index segment_count() const { return static_cast<Eigen::Index>(segments.size()); }
  /// The segment that comes after, or -1.
  Eigen::Index next_of(Eigen::Index segment) const;
  MovingStates moving_states() const;
  /// By which its runs have their patterns: those of `plan_text`. @throws InputError if that cannot be read
  PatternThresholds thresholds() const;
  StateMetric metric() const { return StateMetric(metric_weights); }
  /// Kinds of consecutive segments, run by run, without those that begin before its `settle`: of each run the
  /// longest stretch without a steady segment, whose kind would be round-off.
  std::vector<std::vector<int>> kind_sequences() const;
  /// The model with its fixed values, its coefficients free.
  /// @throws ArgumentError if this program does not know the model
  models::ParametricModel parametric_model() const;
};

struct DatabaseOptions {
  int threads = 0;
  ProgressCallback progress = {};
};

/// Runs the falls of a sweep again, those that were finished or landed, and cuts them at their events. Segments from
/// the release to the first event are left out.
/// @throws ArgumentError if the motions of its model have no events, a coordinate of its points is neither a
/// coefficient (one of ModelInfo::affine_in) nor an initial value, there are fewer than two segments, or all are
/// steady; NoResultError if cancelled.
MotionDatabase build_database(const Sweep& sweep, const DatabaseOptions& options = {});

/// @throws ArgumentError naming the difference: another model, or a fixed value that is another by more than 1e-9 of
/// itself. Values that the database does not fix may be anything.
void require_same_body(const MotionDatabase& database, const models::ParametricModel& model);

/// Most kinds that a chain of them looks back on.
inline constexpr int kMostKindOrder = 5;

/// The chain of its kinds, of the order that runs left out select; of order 0 where they are too few or too short.
struct KindChain {
  MarkovChain chain;
  OrderChoice choice;
};
KindChain kind_chain(const MotionDatabase& database);

}  // namespace samara::motion
