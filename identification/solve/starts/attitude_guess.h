#pragma once

#include <Eigen/Core>

/// Attitudes of flat bodies of which only positions were seen; internal to identification/.
namespace samara::identification {

/// How the normal of a plate is guessed from the acceleration a of its centre. A fluid pushes a plate along
/// its normal: the normal lies along a - g. (Which side is up cannot be told, nor how the plate is turned
/// about its normal.)
struct AttitudeGuess {
  /// The rate at which a - g turns, as the rate of the plate; else no rotation.
  bool turning = false;
  /// rad: turned away from a - g, about two directions at right angles to it
  double tilt_1 = 0.0, tilt_2 = 0.0;
};

/// Body to world, unit quaternion (w, x, y, z), and its rate (1/s).
struct GuessedAttitude {
  Eigen::Vector4d q_WB;
  Eigen::Vector4d rate;
};

/// @param push a - g, world axes, z up, now and `later` seconds after; not zero
GuessedAttitude guess_attitude(const Eigen::Vector3d& push, const Eigen::Vector3d& push_later, double later,
                               const AttitudeGuess& guess);

}  // namespace samara::identification
