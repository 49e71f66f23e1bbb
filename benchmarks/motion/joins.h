#pragma once

#include <span>
#include <vector>

#include "samara/motion/bodies/bodies.h"
#include "samara/motion/ghost/ghost_force.h"

/// Joins of motions as they used to be made, by blending recordings, and what the ghost says of both.
namespace samara::benchmarks::motion_cases {

/// The model of a database from any state, with the coefficients of a segment's run: its recording goes on as long as
/// wanted.
class Recordings {
 public:
  /// @param window of GhostOptions
  explicit Recordings(const motion::MotionDatabase& database, int window = 8);

  /// States at times from the beginning of a segment on, in rows.
  Eigen::MatrixXd from_start(Eigen::Index segment, const Eigen::VectorXd& times) const;
  /// From a state with coefficients that rest.
  Eigen::MatrixXd from_state(const Eigen::VectorXd& state, const Eigen::VectorXd& coefficients,
                             const Eigen::VectorXd& times) const;

  /// The ghost at the best coefficients of the database's box.
  motion::GhostSeries ghost(const Eigen::VectorXd& times, const Eigen::MatrixXd& poses) const;
  const models::ModelInfo& info() const { return model_.model().info(); }

 private:
  const motion::MotionDatabase& database_;
  models::ParametricModel model_;  ///< coefficients and initial states free
  motion::GhostOptions box_;
};

/// Poses x, y, theta of recordings of these segments, one after another, by a C1 blend over `blend` at each join, with
/// the frame interval `dt`.
struct PlanarBlend {
  Eigen::VectorXd times;
  Eigen::MatrixXd poses;
};
PlanarBlend blended_walk(const motion::MotionDatabase& database, const Recordings& recordings,
                         const std::vector<Eigen::Index>& segments, double blend, double dt);

/// Poses of a body in space from `first` to those of `second` (x, y, z, qw, .., in rows), which is turned about the
/// vertical, moved, and taken in the copy of the body's symmetry in which it fits best at the beginning: a quintic
/// blend of places and, by slerp, of rotations, over all frames.
Eigen::MatrixXd blended_in_space(const Eigen::MatrixXd& first, Eigen::MatrixXd second,
                                 motion::BodySymmetry symmetry);

}  // namespace samara::benchmarks::motion_cases
