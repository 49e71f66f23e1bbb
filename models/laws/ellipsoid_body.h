#pragma once

#include "samara/models/added_mass/ellipsoid_integrals.h"
#include "samara/models/laws/rigid_body.h"

/// Mass, inertia and added mass of a body like an ellipsoid about its centre: the first parameters of the
/// laws built on it, with derived defaults from the semi-axes, so that measured or computed values may take
/// their place.
namespace samara::models::laws {

struct EllipsoidBody {
  enum Parameter {
    kA,
    kB,
    kC,
    kDensity,
    kFluidDensity,
    kG,
    kMass,
    kDisplacedMass,
    kInertia,
    kAddedMass = kInertia + 3,
    kAddedInertia = kAddedMass + 3,
    kBuoyancyCentre = kAddedInertia + 3,
    kBodyParameters = kBuoyancyCentre + 3
  };

  static std::vector<ParameterInfo> parameters();

  /// m + M, which with u_r makes the momentum.
  template <class S>
  static Vector3<S> total_mass(const S* p) {
    return {p[kMass] + p[kAddedMass], p[kMass] + p[kAddedMass + 1], p[kMass] + p[kAddedMass + 2]};
  }

  /// I + J
  template <class S>
  static Vector3<S> total_inertia(const S* p) {
    return vector3(p + kInertia) + vector3(p + kAddedInertia);
  }

  /// P_r x w and L x w + kappa (M u_r) x u_r
  template <class S>
  static Load<S> inertial_load(const Vector3<S>& u_r, const Vector3<S>& w, const S& kappa, const S* p) {
    const Vector3<S> added = diagonal_times(vector3(p + kAddedMass), u_r);
    return {cross(p[kMass] * u_r + added, w),
            cross(diagonal_times(total_inertia(p), w), w) + kappa * cross(added, u_r)};
  }

  template <class S>
  static void complete(const char* given, S* p) {
    const S &a = p[kA], &b = p[kB], &c = p[kC];
    const S volume = ellipsoid_volume(a, b, c);
    if (!given[kMass]) p[kMass] = p[kDensity] * volume;
    if (!given[kDisplacedMass]) p[kDisplacedMass] = p[kFluidDensity] * volume;
    S inertia[3];
    store(ellipsoid_inertia(p[kMass], a, b, c), inertia);
    bool has_added = true;
    for (int i = 0; i < 3; ++i) {
      if (!given[kInertia + i]) p[kInertia + i] = inertia[i];
      has_added = has_added && given[kAddedMass + i] && given[kAddedInertia + i];
    }
    if (!has_added) complete_added_mass(given, p[kFluidDensity] * volume, p);
  }

 private:
  template <class S>
  static void complete_added_mass(const char* given, const S& fluid_mass, S* p) {
    S over_mf[6];
    added_mass_over_mf(p, over_mf);
    for (int i = 0; i < 6; ++i) {
      if (!given[kAddedMass + i]) p[kAddedMass + i] = fluid_mass * over_mf[i];
    }
  }

  static void added_mass_over_mf(const double* p, double* over_mf) {
    added_mass::ellipsoid_added_mass(p[kA], p[kB], p[kC], over_mf, over_mf + 3);
  }

  /// The integrals depend on three numbers: differentiated by these alone, and by the chain rule by all
  /// others.
  template <class Jet>
  static void added_mass_over_mf(const Jet* p, Jet* over_mf) {
    using AxisJet = Dual<double, 3>;
    AxisJet axes[3], by_axes[6];
    for (int k = 0; k < 3; ++k) axes[k] = AxisJet(p[kA + k].a, static_cast<std::size_t>(k));
    added_mass::ellipsoid_added_mass(axes[0], axes[1], axes[2], by_axes, by_axes + 3);
    for (int i = 0; i < 6; ++i) {
      over_mf[i].a = by_axes[i].a;
      over_mf[i].v.fill(0.0);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t k = 0; k < over_mf[i].v.size(); ++k)
          over_mf[i].v[k] += by_axes[i].v[axis] * p[kA + axis].v[k];
      }
    }
  }
};

}  // namespace samara::models::laws
