#pragma once

#include <cmath>

#include <Eigen/Geometry>

/// Attitudes and the rotation vectors between them; internal to identification/.
namespace samara::identification {

/// A unit quaternion, body to world. (Eigen stores x, y, z, w; files and states w, x, y, z.)
using Attitude = Eigen::Quaterniond;

inline Attitude attitude_of(const Eigen::Vector4d& wxyz) {
  return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
}

inline Eigen::RowVector4d components(const Attitude& q) {
  return {q.w(), q.x(), q.y(), q.z()};
}

/// The rotation vector phi in body axes with to = from * exp(phi). Its length is below 2 pi and not folded
/// back at pi: quaternions of continuous signs give continuous vectors.
inline Eigen::Vector3d rotation_vector(const Attitude& from, const Attitude& to) {
  const Attitude between = from.conjugate() * to;
  const double sine = between.vec().norm();
  if (sine < 1e-9) return 2.0 * std::copysign(1.0, between.w()) * between.vec();
  return 2.0 * std::atan2(sine, between.w()) / sine * between.vec();
}

/// from * exp(phi), phi in body axes.
inline Attitude turned(const Attitude& from, const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  // sin(a/2)/a to fourth order where it cancels
  const double factor = angle < 1e-3 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  Attitude step(std::cos(0.5 * angle), factor * phi.x(), factor * phi.y(), factor * phi.z());
  return (from * step).normalized();
}

}  // namespace samara::identification
