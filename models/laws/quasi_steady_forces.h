#pragma once

#include <cmath>

#include "samara/models/batch/law_kernel.h"
#include "samara/models/law_tools/reynolds.h"
#include "samara/models/laws/rigid_body.h"

/// Quasi-steady forces of a fluid on a flat body with the outline of an ellipse, normal to body z: drag, the
/// two lifts and rotational damping. After A. Andersen, U. Pesavento, Z. J. Wang, J. Fluid Mech. 541 (2005)
/// 65-90, for the plane; carried to three dimensions so that every term is passive (power on the relative
/// motion never positive) and none depends on the choice of axes in a round disc.
///
///   U = sqrt(|u|^2 + eps^2),  A = pi a b
///   drag               -1/2 rho A (C_D0 (u_x^2 + u_y^2) + C_D90 u_z^2) / U  u
///   translational lift -rho A C_T u_z / U  u x (n x u)                      perpendicular to u
///   rotational lift    1/2 rho A C_R (2b w_x, 2a w_y, 0) x u                perpendicular to u
///   damping            T_x = -1/2 rho C_w 8/15 a b^3 s w_x,  T_y = -1/2 rho C_w 8/15 b a^3 s w_y
///                      with the speed of the rim s = sqrt(b^2 w_x^2 + a^2 w_y^2)
///
/// The small speed eps and the small rate w_eps make them smooth everywhere.
///
/// The rotational lift is the sum of two planar ones, about each axis of the plate with the chord at right angles
/// to it. One chord for both, along the tangential velocity (velocity_chord = 1), agrees in the plane but dips
/// from 2a to 2 sqrt(a b) within a fraction of a millisecond whenever that velocity passes zero.
namespace samara::models::laws {

/// Whether a number is zero in all lanes, with all its tangents: what it would be multiplied by need not be computed.
/// Beside lanes in which it is not zero it is: then zeros of forces may have another sign than alone.
inline bool vanishes(double x) {
  return x == 0.0;
}
inline bool vanishes(const Pack& x) {
  return std::experimental::all_of(x == Pack(0.0));
}
template <class S, int K>
bool vanishes(const Dual<S, K>& x) {
  for (const S& tangent : x.v) {
    if (!vanishes(tangent)) return false;
  }
  return vanishes(x.a);
}

template <class S>
struct QuasiSteadyBody {
  S a, b;                     ///< semi-axes of the outline [m]
  S fluid_density;            ///< [kg/m^3]
  S C_D0, C_D90;              ///< drag coefficients edge-on and broadside
  S C_T, C_R;                 ///< coefficients of translational and rotational lift
  S C_w;                      ///< coefficient of rotational damping
  S isotropy;                 ///< of the damping: 1 by the speed of the rim, 0 by each axis alone
  Vector3<S> linear_damping;  ///< [N m s]
  S speed_floor;              ///< eps [m/s]
  S rate_floor;               ///< w_eps [rad/s]
  S centre_of_pressure;       ///< share of the quarter-chord offset: 0 none, 1 all
  S velocity_chord;           ///< of the rotational lift: 0 by each axis, 1 the chord along the velocity
  ReynoldsSpeeds<S> Re;       ///< of the length 2 a
};

template <class S>
struct QuasiSteadyLoads {
  Load<S> drag, translational_lift, rotational_lift, damping;
};

/// sqrt(|u|^2 + floor^2)
template <class S>
S smooth_norm(const Vector3<S>& u, const S& floor) {
  using std::sqrt;
  return sqrt(dot(u, u) + floor * floor);
}

/// An ellipse seen along the tangential velocity (u_x, u_y): with the floor, |(u_x, u_y)|^2 and the square of
/// 2 a b |(u_x, u_y)| / l, where l is the chord along it.
template <class S>
struct Tangential {
  S speed_2, stretched_2;

  Tangential(const S& a, const S& b, const Vector3<S>& u, const S& floor) {
    const S floor_2 = floor * floor;
    speed_2 = u.x * u.x + u.y * u.y + floor_2;
    stretched_2 = b * b * u.x * u.x + a * a * u.y * u.y + a * b * floor_2;
  }
};

/// Chord of the elliptic outline along the tangential part of u, smooth as a whole: between 2b and 2a, and
/// 2 sqrt(a b) where that part vanishes. [m]
template <class S>
S chord_along(const S& a, const S& b, const Vector3<S>& u, const S& floor) {
  using std::sqrt;
  const Tangential<S> tangential(a, b, u, floor);
  return S(2.0) * a * b * sqrt(tangential.speed_2 / tangential.stretched_2);
}

/// (l_x w_x, l_y w_y, 0), each rate times the chord that it turns: its circulation over C_R/2. [m rad/s]
template <class S>
Vector3<S> rates_of_chords(const QuasiSteadyBody<S>& body, const Vector3<S>& u, const Vector3<S>& w) {
  S along(0.0);
  if (!vanishes(body.velocity_chord))
    along = body.velocity_chord * chord_along(body.a, body.b, u, body.speed_floor);
  const S by_axis = S(2.0) * (S(1.0) - body.velocity_chord);
  return {(by_axis * body.b + along) * w.x, (by_axis * body.a + along) * w.y, S(0.0)};
}

/// p = share (1 - sin^3 alpha) l/4 t, towards the leading edge: a quarter chord at small angles of attack,
/// the centre when broadside. t l = 2 a b (u_x, u_y) / sqrt(b^2 u_x^2 + a^2 u_y^2). [m]
template <class S>
Vector3<S> centre_of_pressure(const QuasiSteadyBody<S>& body, const Vector3<S>& u) {
  using std::abs;
  using std::sqrt;
  if (vanishes(body.centre_of_pressure)) return {};
  const S sin_alpha = abs(u.z) / smooth_norm(u, body.speed_floor);
  const Tangential<S> tangential(body.a, body.b, u, body.speed_floor);
  const S size = body.centre_of_pressure * (S(1.0) - sin_alpha * sin_alpha * sin_alpha) * S(0.5) * body.a *
                 body.b / sqrt(tangential.stretched_2);
  return {size * u.x, size * u.y, S(0.0)};
}

template <class S>
Vector3<S> damping_torque(const QuasiSteadyBody<S>& body, const Vector3<S>& w) {
  using std::sqrt;
  const S &a = body.a, &b = body.b;
  const S floor_2 = body.rate_floor * body.rate_floor;
  const S w_x2 = w.x * w.x;
  const S w_y2 = w.y * w.y;
  const S rim = body.isotropy * sqrt(b * b * w_x2 + a * a * w_y2 + a * b * floor_2);
  const S alone = S(1.0) - body.isotropy;
  S s_x = rim, s_y = rim;
  if (!vanishes(alone)) {
    s_x = rim + alone * b * sqrt(w_x2 + floor_2);
    s_y = rim + alone * a * sqrt(w_y2 + floor_2);
  }
  const S k = S(0.5 * 8.0 / 15.0) * body.fluid_density * body.C_w * a * b;
  const Vector3<S>& linear = body.linear_damping;
  return {-(k * b * b * s_x + linear.x) * w.x, -(k * a * a * s_y + linear.y) * w.y, -linear.z * w.z};
}

/// The loads at velocity u and angular velocity w relative to the fluid, body axes. Drag and lifts are taken
/// at the centre of pressure, from the velocity of that point, so that they stay passive.
///
/// Coefficients follow the Reynolds number as reynolds.h says.
template <class S>
QuasiSteadyLoads<S> quasi_steady_loads(const QuasiSteadyBody<S>& body, const Vector3<S>& u,
                                       const Vector3<S>& w) {
  const Vector3<S> p = centre_of_pressure(body, u);
  const Vector3<S> u_p = u + cross(w, p);
  const S U = smooth_norm(u_p, body.speed_floor);
  const S one_over_U = S(1.0) / U;
  const S of_drag = drag_speed(U, body.Re.drag) * one_over_U;
  S of_lift(1.0);
  if (!vanishes(body.Re.lift)) of_lift = U / (U + body.Re.lift);
  const S rho_A = S(std::numbers::pi) * body.fluid_density * body.a * body.b;

  const S tangential = u_p.x * u_p.x + u_p.y * u_p.y;
  const S drag =
      S(0.5) * rho_A * of_drag * (body.C_D0 * tangential + body.C_D90 * u_p.z * u_p.z) * one_over_U;
  const S lift = rho_A * of_lift * body.C_T * u_p.z * one_over_U;
  const S rotation = S(0.5) * rho_A * of_lift * body.C_R;
  // u x (n x u) = |u|^2 n - u_z u, without the cancellation in its last component.
  const Vector3<S> upward = {-u_p.z * u_p.x, -u_p.z * u_p.y, tangential};
  return {.drag = force_at(p, -drag * u_p),
          .translational_lift = force_at(p, -lift * upward),
          .rotational_lift = force_at(p, rotation * cross(rates_of_chords(body, u_p, w), u_p)),
          .damping = {{}, damping_torque(body, w)}};
}

}  // namespace samara::models::laws
