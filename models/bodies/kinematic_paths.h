#pragma once

#include <Eigen/Core>

/// Paths of falling bodies drawn by formula, without forces: what chapter 3 of the dissertation builds its
/// database of trajectories from. They look like the patterns they are named after and obey no law of motion:
/// use them for pictures, for test data and as first guesses, not for predictions.
///
///   const SideToSidePath leaf = {.descent_speed = 0.4, .horizontal_speed = 0.8, .vertical_speed = 0.2,
///                                .angular_frequency = 6.0};
///   const PathPoint point = at(leaf, 0.3);   // point.position, point.velocity
///
/// World axes: x and y horizontal, z upward; SI units.
namespace samara::models {

struct PathPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, world
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s, world; the derivative of position
};

/// Fluttering from side to side in the plane y = 0, eq. (3.6) (whose text swaps the two amplitudes):
///
///   x = x0 - (A_x/W) sin(W t),   z = z0 - U t - (A_z/(2 W)) cos(2 W t)
///
/// Two vertical swings to one horizontal one; the descent is fastest or slowest where the body turns.
struct SideToSidePath {
  double x0 = 0.0;                 ///< m; x at the start
  double z0 = 0.0;                 ///< m; mean height at the start, which is z0 - A_z/(2 W)
  double descent_speed = 0.0;      ///< U, m/s, positive downward
  double horizontal_speed = 0.0;   ///< A_x, m/s, amplitude
  double vertical_speed = 0.0;     ///< A_z, m/s, amplitude about the descent
  double angular_frequency = 1.0;  ///< W, rad/s, positive
};

/// A descent whose projection on the ground is an ellipse with lobes, eqs. (3.7)-(3.8):
///
///   (x, y) = (A_x cos(W t), A_y sin(W t)) (1 + eps sin(k W t)),   z = z0 - U t
///
/// eps is the depth of the modulation (the source calls it an aspect ratio), and k the number of lobes. eps =
/// 0 with A_x = A_y is a circle for any k: the spiral. k = 4: the helix, with four lobes (eight petals for
/// |eps| > 1 only). A_x = A_y = 0: steady descent. A_y = 0: a straight line, for flutter and tumbling seen
/// from above, which one amplitude (A_e in the source) cannot give.
struct RosePath {
  double z0 = 0.0;                 ///< m; release height
  double descent_speed = 0.0;      ///< U, m/s, positive downward
  double amplitude_x = 0.0;        ///< A_x, m
  double amplitude_y = 0.0;        ///< A_y, m
  double modulation = 0.0;         ///< eps, 1
  double lobes = 1.0;              ///< k, 1: lobes per revolution
  double angular_frequency = 1.0;  ///< W, rad/s, positive
};

/// @throws ArgumentError if t or a number of the path is not finite, or the frequency is not positive.
PathPoint at(const SideToSidePath& path, double t);
PathPoint at(const RosePath& path, double t);

}  // namespace samara::models
