#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "samara/models/law_tools/attitude.h"
#include "samara/models/law_tools/drag_scales.h"
#include "samara/models/law_tools/vector3.h"
#include "samara/models/laws/law_model.h"

/// What all bodies with a full pose share: their thirteen states, loads, weight and scales.
namespace samara::models::laws {

/// The states of a body: position of its origin, attitude, velocity and angular velocity in body axes.
enum PoseState { kPosition, kQw = 3, kUx = 7, kWx = 10, kPoseStates = 13 };

std::vector<StateInfo> pose_states();
std::vector<StateGroup> pose_groups();

/// "translation of x" and so on: f does not depend on the position.
std::vector<std::string> translations();
/// These, and "rotation about z": gravity is all that tells directions apart.
std::vector<std::string> upright_symmetries();

template <class S>
struct Pose {
  explicit Pose(const S* x) : R(rotation(x + kQw)), u(vector3(x + kUx)), w(vector3(x + kWx)) {}

  Rotation<S> R;
  Vector3<S> u;  ///< velocity of the origin, body axes [m/s]
  Vector3<S> w;  ///< angular velocity, body axes [rad/s]
};

/// Rates of position and attitude.
template <class S>
void pose_rates(const Pose<S>& pose, const S* x, S* dxdt) {
  store(pose.R.to_world(pose.u), dxdt + kPosition);
  quaternion_rate(x + kQw, pose.w, dxdt + kQw);
}

/// Force [N] and torque about the origin [N m], in body axes.
template <class S>
struct Load {
  Vector3<S> force, torque;
};

template <class S>
Load<S> operator+(const Load<S>& a, const Load<S>& b) {
  return {a.force + b.force, a.torque + b.torque};
}

/// A force that acts at `point`, body axes.
template <class S>
Load<S> force_at(const Vector3<S>& point, const Vector3<S>& force) {
  return {force, cross(point, force)};
}

/// Weight at the origin and buoyancy at r_b:
///   F = (m - m_f) R^T g_w,   T = -m_f r_b x R^T g_w,   g_w = (0, 0, -g).
/// Dissertation (5.19) prints the torque with the other sign, which turns a bottom-heavy body over.
template <class S>
Load<S> gravity_and_buoyancy(const Rotation<S>& R, const S& mass, const S& displaced_mass,
                             const Vector3<S>& r_b, const S& g) {
  const Vector3<S> g_b = -g * Vector3<S>{R.x_axis.z, R.y_axis.z, R.z_axis.z};
  return {(mass - displaced_mass) * g_b, -displaced_mass * cross(r_b, g_b)};
}

template <class S>
LawWrench<S> wrench(const Load<S>& load, const Vector3<S>& u_r, const Vector3<S>& w) {
  LawWrench<S> result;
  store(load.force, result.force);
  store(load.torque, result.torque);
  result.power = dot(load.force, u_r) + dot(load.torque, w);
  return result;
}

/// 4/3 pi a b c
template <class S>
S ellipsoid_volume(const S& a, const S& b, const S& c) {
  return S(4.0 / 3.0 * std::numbers::pi) * a * b * c;
}

/// Principal moments of a solid ellipsoid of mass m.
template <class S>
Vector3<S> ellipsoid_inertia(const S& m, const S& a, const S& b, const S& c) {
  const S fifth = m / S(5.0);
  return {fifth * (b * b + c * c), fifth * (a * a + c * c), fifth * (a * a + b * b)};
}

/// Characteristic sizes of a body of extent `length` [m] that fluid slows by k u^2 [k: kg/m] against the
/// force `drive` [N]: the speed at which they balance, and the time to move by its length. The drive counts
/// as no less than a thousandth of the standard weight of `mass` [kg], positive.
Scales body_scales(double length, double drive, double mass, double k);

}  // namespace samara::models::laws
