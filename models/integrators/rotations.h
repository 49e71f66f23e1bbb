#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>  // cross products

/// Exponentials on the groups of rotations and of rigid motions; quaternions are (w, x, y, z), body to world.
/// (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., 2006, IV.7; J. M. Selig,
/// Geometric Fundamentals of Robotics, 2nd ed., 2005, 4.3.)
namespace samara::models {

using Quaternion = std::array<double, 4>;

/// p q: first the turn q, then p.
inline Quaternion product(const Quaternion& p, const Quaternion& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
          p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
          p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1]};
}

/// The inverse of a unit quaternion.
inline Quaternion conjugate(const Quaternion& q) {
  return {q[0], -q[1], -q[2], -q[3]};
}

/// q over its norm: the same rotation.
inline Quaternion normalised(const Quaternion& q) {
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm};
}

/// R s for the rotation R of a unit quaternion.
inline Eigen::Vector3d rotate(const Quaternion& q, const Eigen::Vector3d& s) {
  const Eigen::Vector3d v(q[1], q[2], q[3]);
  const Eigen::Vector3d twice = 2.0 * v.cross(s);
  return s + q[0] * twice + v.cross(twice);
}

/// The rotation by the vector theta (axis times angle).
inline Quaternion rotation_exponential(const Eigen::Vector3d& theta) {
  const double half = 0.5 * theta.norm();
  // sin(half)/(2 half): below 1e-4 the next term of its series is less than round-off.
  const double k = half < 1e-4 ? 0.5 * (1.0 - half * half / 6.0) : 0.5 * std::sin(half) / half;
  return {std::cos(half), k * theta.x(), k * theta.y(), k * theta.z()};
}

/// A rigid motion: s -> R s + x.
struct RigidMotion {
  Quaternion q = {1.0, 0.0, 0.0, 0.0};
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
};

/// The motion with constant velocity u and angular velocity w, both in body axes, over unit time: R = exp[w],
/// x = (1 + (1 - cos a)/a^2 [w] + (a - sin a)/a^3 [w]^2) u with a = |w|.
inline RigidMotion rigid_exponential(const Eigen::Vector3d& u, const Eigen::Vector3d& w) {
  const double a2 = w.squaredNorm();
  const double a = std::sqrt(a2);
  double first, second;
  if (a < 0.5) {
    // Power series sum (-a^2)^n/(2n+2)! and sum (-a^2)^n/(2n+3)!, cut where terms are below round-off.
    first = second = 0.0;
    for (int n = 7; n >= 0; --n) {
      first = 1.0 / ((2.0 * n + 1.0) * (2.0 * n + 2.0)) * (1.0 - a2 * first);
      second = 1.0 / ((2.0 * n + 2.0) * (2.0 * n + 3.0)) * (1.0 - a2 * second);
    }
  } else {
    const double s = std::sin(0.5 * a);
    first = 2.0 * s * s / a2;
    second = (a - std::sin(a)) / (a2 * a);
  }
  const Eigen::Vector3d w_u = w.cross(u);
  return {rotation_exponential(w), u + first * w_u + second * w.cross(w_u)};
}

}  // namespace samara::models
