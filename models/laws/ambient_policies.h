#pragma once

#include <vector>

#include "samara/models/interface/model.h"
#include "samara/models/laws/vector3.h"

/// Ambient flows that laws are built on: what the undisturbed fluid does where the body is.
///
/// A policy lists parameters of its own, which follow those of the law, and fills in an Ambient:
///   static constexpr int kParameters;
///   static std::vector<ParameterInfo> parameters();
///   template <class S>
///   Ambient<S> at(const S& t, const Vector3<S>& position, const Vector3<S>& v, const S* p) const;
/// where v is the velocity of the body in world axes.
namespace samara::models::laws {

/// World axes.
template <class S>
struct Ambient {
  Vector3<S> velocity;       ///< w_air [m/s]
  Vector3<S> path_rate;      ///< its rate along the body's path, dw_air/dt + (v . grad) w_air [m/s^2]
  Vector3<S> material_rate;  ///< its rate along its own path, D w_air/Dt [m/s^2]
};

struct StillFluid {
  static constexpr int kParameters = 0;
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
    const Vector3<S> shear = {p[3], p[4], S(0.0)};
    return {wind + position.z * shear, v.z * shear, wind.z * shear};
  }
};

}  // namespace samara::models::laws
