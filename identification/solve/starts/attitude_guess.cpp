#include "samara/identification/solve/starts/attitude_guess.h"

#include <algorithm>

#include "samara/models/integrators/rotations.h"

namespace samara::identification {

namespace {

/// The shortest turn of the world's z axis to a direction.
models::Quaternion turn_of_z(const Eigen::Vector3d& n) {
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ().cross(n);
  // Half the angle from the bisector: (1 + cos, sin * axis), which is lost only where n points straight down.
  const double w = std::max(1.0 + n.z(), 1e-9);
  return models::normalised({w, axis.x(), axis.y(), axis.z()});
}

}  // namespace

GuessedAttitude guess_attitude(const Eigen::Vector3d& push, const Eigen::Vector3d& push_later, double later,
                               const AttitudeGuess& guess) {
  // Of the two sides the upper one.
  const double side = push.z() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d n = side * push.normalized();
  const Eigen::Vector3d n_later = side * push_later.normalized();
  const models::Quaternion q =
      models::product(turn_of_z(n), models::rotation_exponential({guess.tilt_1, guess.tilt_2, 0.0}));
  GuessedAttitude result{.q_WB = {q[0], q[1], q[2], q[3]}, .rate = Eigen::Vector4d::Zero()};
  if (!guess.turning) return result;
  const Eigen::Vector3d w = n.cross(n_later) / later;  // world axes: q' = 1/2 (0, w) q
  const models::Quaternion rate = models::product({0.0, w.x(), w.y(), w.z()}, q);
  result.rate = 0.5 * Eigen::Vector4d(rate[0], rate[1], rate[2], rate[3]);
  return result;
}

}  // namespace samara::identification
