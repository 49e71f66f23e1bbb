#pragma once

#include <array>
#include <string>

#include "samara/models/laws/spatial_inertia.h"

namespace samara::models::laws {

/// What laws of a body with a constant inertia on (u, w) and a list of loads have in common. The Law gives
///
///   template <class S> static SpatialInertia<S> total_inertia(const S* p);  // of body and fluid
///   template <class S> static std::array<Load<S>, kTerms> loads(const Pose<S>&, const SpatialInertia<S>&,
///                                                               const S* p);  // inertial ones included
template <class Law>
struct SpatialBody {
  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    const Pose<S> pose(x);
    const SpatialInertia<S> inertia = Law::total_inertia(p);
    Load<S> sum;
    for (const Load<S>& load : Law::loads(pose, inertia, p)) sum = sum + load;
    const Load<S> rates = inertia.solve(sum);
    pose_rates(pose, x, dxdt);
    store(rates.force, dxdt + kUx);
    store(rates.torque, dxdt + kWx);
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    const Pose<S> pose(x);
    for (const Load<S>& load : Law::loads(pose, Law::total_inertia(p), p)) {
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

}  // namespace samara::models::laws
