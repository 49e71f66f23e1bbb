#pragma once

#include <vector>

#include "samara/models/interface/model.h"
#include "samara/models/law_tools/vector3.h"

/// Ambient flows that laws are built on: what the undisturbed fluid does where the body is.
///
/// A policy lists parameters of its own, which follow those of the law, and fills in an Ambient:
///   static constexpr int kParameters;
///   static std::vector<ParameterInfo> parameters();
///   template <class S>
///   Ambient<S> at(const S& t, const Vector3<S>& position, const Vector3<S>& v, const S* p) const;
/// where v is the velocity of the body in world axes. One whose fluid turns as a whole (Ambient::rotation) says so by
///   static constexpr bool kTurns = true;
/// and one that is the same everywhere, without an Ambient::gradient, by
///   static constexpr bool kUniform = true;
namespace samara::models::laws {

/// Of a velocity: its derivatives along the axes of the world [1/s].
template <class S>
struct Gradient {
  Vector3<S> by_x = {}, by_y = {}, by_z = {};

  /// (v . grad) w_air, the gradient times v
  Vector3<S> along(const Vector3<S>& v) const { return v.x * by_x + v.y * by_y + v.z * by_z; }
  /// Its transposed times q.
  Vector3<S> transposed_times(const Vector3<S>& q) const {
    return {dot(by_x, q), dot(by_y, q), dot(by_z, q)};
  }
};

/// World axes.
template <class S>
struct Ambient {
  Vector3<S> velocity;       ///< w_air [m/s]
  Vector3<S> path_rate;      ///< its rate along the body's path, dw_air/dt + (v . grad) w_air [m/s^2]
  Vector3<S> material_rate;  ///< its rate along its own path, D w_air/Dt [m/s^2]
  Vector3<S> rotation = {};  ///< angular velocity of eddies larger than the body [rad/s]
  Gradient<S> gradient = {};
};

struct StillFluid {
  static constexpr int kParameters = 0;
  static constexpr bool kUniform = true;
  static std::vector<ParameterInfo> parameters() { return {}; }

  template <class S>
  Ambient<S> at(const S&, const Vector3<S>&, const Vector3<S>&, const S*) const {
    return {};
  }
};

/// A steady horizontal wind that changes linearly with height, with a uniform vertical part:
///   w_air = (wind_x + shear_x z, wind_y + shear_y z, wind_z).
struct LinearWind {
  static constexpr int kParameters = 5;

  static std::vector<ParameterInfo> parameters() {
    return {
        {.name = "wind_x", .unit = "m/s", .default_value = 0.0, .description = "wind along x at z = 0"},
        {.name = "wind_y", .unit = "m/s", .default_value = 0.0, .description = "wind along y at z = 0"},
        {.name = "wind_z", .unit = "m/s", .default_value = 0.0, .description = "wind along z, upward"},
        {.name = "shear_x",
         .unit = "1/s",
         .default_value = 0.0,
         .description = "increase of wind_x with height"},
        {.name = "shear_y",
         .unit = "1/s",
         .default_value = 0.0,
         .description = "increase of wind_y with height"},
    };
  }

  template <class S>
  Ambient<S> at(const S&, const Vector3<S>& position, const Vector3<S>& v, const S* p) const {
    const Vector3<S> wind = vector3(p);
    const Gradient<S> shear = {.by_z = {p[3], p[4], S(0.0)}};
    return {.velocity = wind + position.z * shear.by_z,
            .path_rate = shear.along(v),
            .material_rate = shear.along(wind),
            .gradient = shear};
  }
};

/// A velocity that changes linearly in time from `gust_start` on, and by a constant gradient about the body: what a
/// driver sets for every step of a body in gusts (models/stochastic/gust_layout.h), so that its added mass and the
/// pressure gradient act on them.
struct GustRamp {
  static constexpr int kParameters = 19;
  static constexpr bool kTurns = true;

  static std::vector<ParameterInfo> parameters() {
    std::vector<ParameterInfo> list = {
        parameter("gust_start", "s", "time at which the velocity is (gust_x, gust_y, gust_z)")};
    for (const char* name : {"gust_x", "gust_y", "gust_z"})
      list.push_back(parameter(name, "m/s", "velocity of the fluid at gust_start"));
    for (const char* name : {"gust_rate_x", "gust_rate_y", "gust_rate_z"})
      list.push_back(parameter(name, "m/s^2", "its rate along the path of the body"));
    for (const char* name :
         {"gust_gradient_xx", "gust_gradient_xy", "gust_gradient_xz", "gust_gradient_yx", "gust_gradient_yy",
          "gust_gradient_yz", "gust_gradient_zx", "gust_gradient_zy", "gust_gradient_zz"})
      list.push_back(parameter(name, "1/s", "derivative of its first axis's component by the second axis"));
    for (const char* name : {"gust_spin_x", "gust_spin_y", "gust_spin_z"})
      list.push_back(parameter(name, "rad/s", "angular velocity of the fluid, world axes"));
    return list;
  }

  template <class S>
  Ambient<S> at(const S& t, const Vector3<S>&, const Vector3<S>& v, const S* p) const {
    const Vector3<S> rate = vector3(p + 4);
    const Vector3<S> velocity = vector3(p + 1) + (t - p[0]) * rate;
    const Gradient<S> gradient = {
        {p[7], p[10], p[13]}, {p[8], p[11], p[14]}, {p[9], p[12], p[15]}};  // p row by row
    return {velocity, rate, rate + gradient.along(velocity - v), vector3(p + 16), gradient};
  }

 private:
  static ParameterInfo parameter(const char* name, const char* unit, const char* description) {
    return {.name = name, .unit = unit, .default_value = 0.0, .description = description};
  }
};

/// The angular velocity w [body axes] of a body with axes R, relative to the fluid.
template <class Flow, class S, class Axes>
Vector3<S> relative_rate(const Axes& R, const Vector3<S>& w, const Ambient<S>& ambient) {
  if constexpr (requires { Flow::kTurns; }) {
    return w - R.to_body(ambient.rotation);
  } else {
    return w;
  }
}

/// What the gradient G does to the impulse q of the fluid that a body sets in motion relative to it (M u_r), both in
/// body axes: the force -R^T G^T R q. In a potential flow it follows from the kinetic energy 1/2 u_r . M u_r by
/// Lagrange's equations; with -M du_r/dt it makes of the force on a sphere that of T. Auton, J. Hunt and
/// M. Prud'homme, J. Fluid Mech. 197 (1988) 241: m_f/2 (Dw_air/Dt - dv/dt) and the lift
/// m_f/2 (w_air - v) x curl w_air.
template <class Flow, class S, class Axes>
Vector3<S> gradient_force(const Axes& R, const Vector3<S>& q, const Ambient<S>& ambient) {
  if constexpr (requires { Flow::kUniform; }) {
    return {};
  } else {
    return S(-1.0) * R.to_body(ambient.gradient.transposed_times(R.to_world(q)));
  }
}

}  // namespace samara::models::laws
