#pragma once

#include <Eigen/Core>

#include "samara/identification/smoothing/continuous_angles.h"
#include "samara/identification/smoothing/smoothing.h"

namespace samara::identification {

/// Rows: the times asked for.
struct SmoothedAttitude {
  Eigen::MatrixX4d attitude;              ///< unit quaternions (w, x, y, z), body to world
  Eigen::MatrixX3d angular_velocity;      ///< w_WB_B, rad/s: of the body in the world, in body axes
  Eigen::MatrixX3d angular_acceleration;  ///< d/dt of it, rad/s^2
  Eigen::MatrixX3d attitude_error;        ///< standard errors of a small rotation about the body axes, rad
  Eigen::MatrixX3d angular_velocity_error;
  Eigen::MatrixX3d angular_acceleration_error;
  Eigen::VectorXd span;                           ///< s, from the first to the last frame that was used
  double noise = 0.0;                             ///< standard deviation of one frame about one axis, rad
  Eigen::Array<bool, Eigen::Dynamic, 1> outlier;  ///< frames
};

/// Attitudes: made continuous, then smoothed as rotation vectors from a local reference.
/// @param quaternions frames x 4, (w, x, y, z), body to world, of any length but 0; NaN where not seen. The
///   body must turn by less than a turn within half a bandwidth.
/// @throws ArgumentError as smooth()
SmoothedAttitude smooth_attitude(const Eigen::VectorXd& times, const Eigen::MatrixX4d& quaternions,
                                 const Eigen::VectorXd& at, const SmoothingOptions& options = {},
                                 const BodySymmetries& symmetries = {});

}  // namespace samara::identification
