#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/captures/capture.h"
#include "samara/models/interface/model.h"

/// A motion as places and attitudes at frames, whoever made it, and what its frames say of velocities and
/// accelerations.
namespace samara::motion {

/// SI, or the units of a dimensionless model; frames in rows.
struct PosePath {
  Eigen::VectorXd times;
  /// In space x, y, z, qw, qx, qy, qz (body to world, quaternions of one length along the path, signs of no matter); in
  /// a plane x, y (up), theta, unwrapped.
  Eigen::MatrixXd poses;

  bool is_planar() const { return poses.cols() == 3; }
};

/// The poses of states of a model, frames in rows.
/// @throws ArgumentError if the model moves no body
PosePath path_of(const models::ModelInfo& model, const Eigen::VectorXd& times, const Eigen::MatrixXd& states);

/// Of a capture with all channels x, y, theta, or x, y, z, qw, qx, qy, qz. Frames where any of them was not seen are
/// refused: what lies between two frames is a polynomial.
/// @throws as identification::refuse(), naming the channel or the frame
PosePath path_of(const identification::Capture& capture);

/// Frames at each end of which nothing is said of rates.
inline constexpr Eigen::Index kEndFrames = 3;
/// Frames that a path has at least.
inline constexpr Eigen::Index kFewestPoses = 2 * kEndFrames + 1;

/// Velocities of the body's origin and rotation rate in body axes (ux, uy, uz, wx, wy, wz; of a planar motion vx, vy,
/// w) and their rates, of frames kEndFrames .. frames - 1 - kEndFrames, in rows.
struct PathRates {
  Eigen::MatrixXd velocities, accelerations;
};

/// Standard deviations of the noise of a frame: of a coordinate of its place, and of a component of its rotation [rad].
/// From eighth divided differences: of frames without noise they are what polynomials through seven of them do not see.
struct PathNoise {
  double position = 0.0, angle = 0.0;
};
PathNoise noise_of(const PosePath& path);

/// Of a second derivative in the middle of seven frames, over the noise of one: the mean square along the path.
double mean_square_gain(const PosePath& path);

/// From the polynomial of degree six through seven frames: errors of the order dt^6. Positions, and the rotation
/// vectors from the middle frame to the others, are interpolated.
/// @throws ArgumentError naming the frame: fewer than 7 frames, times that do not increase, numbers that
/// are not finite, quaternions of no length or whose length changes by more than 1e-3 of itself (files round), more
/// than 2 rad of turn between a frame and the third after it.
PathRates path_rates(const PosePath& path);

}  // namespace samara::motion
