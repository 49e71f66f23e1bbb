#pragma once

#include <array>
#include <string>

#include "samara/models/law_tools/parameter_list.h"
#include "samara/models/laws/ambient_policies.h"
#include "samara/models/laws/spatial_inertia.h"

namespace samara::models::laws {

/// What laws of a body with a constant inertia on (u, w) and a list of loads have in common. The Law gives
///
///   template <class S> static SpatialInertia<S> total_inertia(const S* p);  // of body and fluid
///   template <class S> static std::array<Load<S>, kTerms> loads(const Pose<S>&, const Vector3<S>& w_r,
///                                                               const SpatialInertia<S>&, const S* p);
///
/// these with the inertial ones, w_r the angular velocity relative to the fluid.
template <class Law>
struct SpatialBody {
  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    const Pose<S> pose(x);
    const SpatialInertia<S> inertia = Law::total_inertia(p);
    Load<S> sum;
    for (const Load<S>& load : Law::loads(pose, pose.w, inertia, p)) sum = sum + load;
    const Load<S> rates = inertia.solve(sum);
    pose_rates(pose, x, dxdt);
    store(rates.force, dxdt + kUx);
    store(rates.torque, dxdt + kWx);
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    const Pose<S> pose(x);
    for (const Load<S>& load : Law::loads(pose, pose.w, Law::total_inertia(p), p)) {
      *terms++ = wrench(load, pose.u, pose.w);
    }
  }

  /// 1/2 (u . P + w . L)
  template <class S>
  static S kinetic_energy(const S&, const S* x, const S* p) {
    const Pose<S> pose(x);
    const Load<S> momentum = Law::total_inertia(p).momentum(pose.u, pose.w);
    return S(0.5) * (dot(pose.u, momentum.force) + dot(pose.w, momentum.torque));
  }

  static std::string problem(const double* p) {
    if (Law::total_inertia(p).is_positive_definite()) return "";
    return "masses and moments of inertia, added ones included, do not make a positive definite inertia";
  }

  /// Nothing follows from other parameters.
  template <class S>
  static void complete(const char*, S*) {}
};

/// Masses of a body and the fluid in its place, each with its moment about the origin, in body axes.
template <class S>
struct PlacedMasses {
  S mass, displaced;
  Vector3<S> moment, displaced_moment;  ///< mass times centre [kg m]
};

/// A law of SpatialBody in a fluid that moves with W(t) and changes by the gradient G about the body. With
/// u_r = u - R^T W, (P, L) = (M_body + K) (u_r, w) and (P_f, L_f) = K (u_r, w),
///
///   dP/dt = P x w             + F + m_f R^T DW/Dt - m R^T dW/dt - R^T G^T R P_f
///   dL/dt = L x w + P x u_r   + T + m_f r_b x R^T DW/Dt - m r_c x R^T dW/dt
///
/// which is Kirchhoff's equation for M_body (u, w) + K (u_r, w): what W turns with cancels by Jacobi's identity. F
/// and T are those of the law at u_r, and what damps rotation is at w_r = w - R^T gust_spin; the force by G:
/// gradient_force(). The Law gives as well
///
///   template <class S> static PlacedMasses<S> masses(const S* p);
///   static void say_gusts(ModelInfo& info);  // title and equations with W
template <class Law>
struct SpatialBodyInGusts {
  static constexpr int kStates = Law::kStates;
  static constexpr int kGust = Law::kParameters;
  static constexpr int kParameters = kGust + GustRamp::kParameters;

  static ModelInfo info() {
    ModelInfo info = Law::info();
    info.name += "_in_gusts";
    info.validity +=
        "; the fluid changes little over the length of the body. Realisations (samara simulate "
        "--realisations) set the gust step by step; by itself it is one ramp in time";
    // No rotation about z: the gust would have to turn with the state.
    info.symmetries = translations();
    append(info.parameters, GustRamp::parameters());
    info.force_terms.push_back({.name = "ambient acceleration",
                                .description =
                                    "pressure gradient of the undisturbed fluid, m_f D w_air/Dt, "
                                    "less m times the rate of w_air along the path, and -R^T W^T R P_f by "
                                    "its gradient W"});
    Law::say_gusts(info);
    return info;
  }

  template <class S>
  static Ambient<S> air_at(const S& t, const S* x, const S* p) {
    const Pose<S> pose(x);
    return GustRamp().at(t, vector3(x + kPosition), pose.R.to_world(pose.u), p + kGust);
  }

  /// The pose as the fluid sees it: velocities relative to it.
  template <class S>
  static Pose<S> relative(const S* x, const Ambient<S>& air) {
    Pose<S> pose(x);
    pose.u = pose.u - pose.R.to_body(air.velocity);
    return pose;
  }

  template <class S>
  static std::array<Load<S>, Law::kTerms + 1> loads(const Pose<S>& pose, const SpatialInertia<S>& inertia,
                                                    const Ambient<S>& air, const S* p) {
    const Vector3<S> w_r = pose.w - pose.R.to_body(air.rotation);
    const std::array<Load<S>, Law::kTerms> still = Law::loads(pose, w_r, inertia, p);
    std::array<Load<S>, Law::kTerms + 1> all;
    for (std::size_t k = 0; k < still.size(); ++k) all[k] = still[k];
    const PlacedMasses<S> masses = Law::masses(p);
    const Vector3<S> material = pose.R.to_body(air.material_rate), path = pose.R.to_body(air.path_rate);
    const Vector3<S> of_body = masses.mass * pose.u + cross(pose.w, masses.moment);
    const Vector3<S> impulse = inertia.momentum(pose.u, pose.w).force - of_body;
    all[still.size()] = {
        masses.displaced * material - masses.mass * path + gradient_force<GustRamp>(pose.R, impulse, air),
        cross(masses.displaced_moment, material) - cross(masses.moment, path)};
    return all;
  }

  template <class S>
  static void rhs(const S& t, const S* x, const S* p, S* dxdt) {
    const Ambient<S> air = air_at(t, x, p);
    const Pose<S> pose(x);
    const SpatialInertia<S> inertia = Law::total_inertia(p);
    Load<S> sum;
    for (const Load<S>& load : loads(relative(x, air), inertia, air, p)) sum = sum + load;
    const Load<S> rates = inertia.solve(sum);
    pose_rates(pose, x, dxdt);
    const Vector3<S> w_air = pose.R.to_body(air.velocity);
    store(rates.force + pose.R.to_body(air.path_rate) + cross(w_air, pose.w), dxdt + kUx);
    store(rates.torque, dxdt + kWx);
  }

  template <class S>
  static void forces(const S& t, const S* x, const S* p, LawWrench<S>* terms) {
    const Ambient<S> air = air_at(t, x, p);
    const Pose<S> pose = relative(x, air);
    for (const Load<S>& load : loads(pose, Law::total_inertia(p), air, p))
      *terms++ = wrench(load, pose.u, pose.w);
  }

  /// 1/2 (u_r . P + w . L)
  template <class S>
  static S kinetic_energy(const S& t, const S* x, const S* p) {
    const Pose<S> pose = relative(x, air_at(t, x, p));
    const Load<S> momentum = Law::total_inertia(p).momentum(pose.u, pose.w);
    return S(0.5) * (dot(pose.u, momentum.force) + dot(pose.w, momentum.torque));
  }

  static std::string problem(const double* p) { return Law::problem(p); }

  template <class S>
  static void complete(const char* given, S* p) {
    Law::complete(given, p);
  }

  static Scales scales(const double* p) { return Law::scales(p); }
};

/// In the equations of a law in still fluid, quantities relative to one that moves.
inline void replace_in(std::string& text, const std::string& old, const std::string& by) {
  for (std::size_t at = text.find(old); at != std::string::npos; at = text.find(old, at + by.size()))
    text.replace(at, old.size(), by);
}

/// What all these equations end with.
inline constexpr const char* kGustEquations =
    ";  u_r = u - R^T w_air;  (P_f, L_f) = K (u_r, w);  w_r = w - R^T (gust_spin_x, gust_spin_y, "
    "gust_spin_z);  "
    "w_air = (gust_x, gust_y, gust_z) + (t - gust_start) (gust_rate_x, gust_rate_y, gust_rate_z);  "
    "a_f = (gust_rate_x, gust_rate_y, gust_rate_z) - W R u_r;  "
    "W has the rows (gust_gradient_xx, gust_gradient_xy, gust_gradient_xz) and so on";

}  // namespace samara::models::laws
