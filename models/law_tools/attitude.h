#pragma once

#include "samara/models/law_tools/vector3.h"

/// Attitude of a body by a quaternion q = (w, x, y, z), body to world.
namespace samara::models::laws {

/// The rotation matrix R of a quaternion, body to world, by its columns.
template <class S>
struct Rotation {
  Vector3<S> x_axis, y_axis, z_axis;  ///< body axes in world components

  Vector3<S> to_world(const Vector3<S>& u) const { return u.x * x_axis + u.y * y_axis + u.z * z_axis; }
  Vector3<S> to_body(const Vector3<S>& u) const { return {dot(x_axis, u), dot(y_axis, u), dot(z_axis, u)}; }
};

/// R of q / |q|: orthonormal for every q but zero, so that neither the error an integrator makes in |q| nor a
/// start that is not quite of unit length changes a force.
template <class S>
Rotation<S> rotation(const S* q) {
  const S &w = q[0], &x = q[1], &y = q[2], &z = q[3];
  const S k = S(2.0) / (w * w + x * x + y * y + z * z);
  const S one(1.0);
  return {{one - k * (y * y + z * z), k * (x * y + w * z), k * (x * z - w * y)},
          {k * (x * y - w * z), one - k * (x * x + z * z), k * (y * z + w * x)},
          {k * (x * z + w * y), k * (y * z - w * x), one - k * (x * x + y * y)}};
}

/// q' = 1/2 q * (0, w) for the angular velocity w in body axes. Exactly, |q| does not change.
template <class S>
void quaternion_rate(const S* q, const Vector3<S>& w, S* dq_dt) {
  const S half(0.5);
  dq_dt[0] = -half * (q[1] * w.x + q[2] * w.y + q[3] * w.z);
  dq_dt[1] = half * (q[0] * w.x + q[2] * w.z - q[3] * w.y);
  dq_dt[2] = half * (q[0] * w.y + q[3] * w.x - q[1] * w.z);
  dq_dt[3] = half * (q[0] * w.z + q[1] * w.y - q[2] * w.x);
}

}  // namespace samara::models::laws
