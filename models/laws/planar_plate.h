#pragma once

#include <array>
#include <cstddef>

#include "samara/models/law_tools/reynolds.h"
#include "samara/models/laws/law_model.h"

/// What all laws of plates moving in a vertical plane share: their states, and the quasi-steady forces of
/// A. Andersen, U. Pesavento, Z. J. Wang, Unsteady aerodynamics of fluttering and tumbling plates, J. Fluid
/// Mech. 541 (2005) 65-90.
///
/// Body axes: x' along the chord, y' along the normal, theta the angle of x' above the horizontal. Everything
/// is per unit span; a law may as well put in dimensionless numbers.
namespace samara::models::laws {

enum PlanarState { kVx, kVy, kOmega, kTheta, kX, kY, kPlanarStates };

/// The terms of the plates, in the order of planar_force_terms().
enum PlanarTerm { kInertia, kTranslationalLift, kRotationalLift, kDrag, kDissipation, kWeight, kPlanarTerms };

/// Force along x' and y' [N/m] and torque about a point said elsewhere [N].
template <class S>
struct PlanarForce {
  S x = S(0.0);
  S y = S(0.0);
  S torque = S(0.0);
};

template <class S>
using PlanarForces = std::array<PlanarForce<S>, kPlanarTerms>;  ///< by PlanarTerm

/// Velocity of the plate's centre in body axes, and its rotation rate.
template <class S>
struct PlanarMotion {
  S vx, vy, w;
};

/// The coefficients of the terms that the flow makes, at the plate's centre.
template <class S>
struct PlanarFlow {
  S lift_T;      ///< translational lift, lift_T vx vy/v (vy, -vx)
  S lift_R;      ///< rotational lift, lift_R w (-vy, vx)
  S drag_chord;  ///< drag, -(drag_chord vx^2 + drag_normal vy^2 + drag_floor speed_floor^2)/v (vx, vy)
  S drag_normal;
  S drag_floor;
  S damping;  ///< dissipation, -(damping + damping_abs |w|) w
  S damping_abs;
  S speed_floor;  ///< v = sqrt(vx^2 + vy^2 + speed_floor^2)
  ReynoldsSpeeds<S> Re;
};

/// Lifts and drag, which follow the Reynolds number as reynolds.h says, and dissipation; leaves inertia and
/// weight at zero.
template <class S>
PlanarForces<S> flow_forces(const PlanarFlow<S>& flow, const PlanarMotion<S>& at) {
  using std::abs;
  using std::sqrt;
  const S vx2 = at.vx * at.vx;
  const S vy2 = at.vy * at.vy;
  const S floor2 = flow.speed_floor * flow.speed_floor;
  const S v2 = vx2 + vy2 + floor2;
  const S v = sqrt(v2);
  const S over_v = S(1.0) / (v + flow.Re.lift);  // 1/v / (1 + Re_lift/Re)
  const S translational = flow.lift_T * at.vx * at.vy * over_v;
  const S rotational = flow.lift_R * at.w * v * over_v;
  const S drag = (flow.drag_chord * vx2 + flow.drag_normal * vy2 + flow.drag_floor * floor2) *
                 drag_speed(v, flow.Re.drag) / v2;
  PlanarForces<S> terms;
  terms[kTranslationalLift] = {translational * at.vy, -translational * at.vx};
  terms[kRotationalLift] = {-rotational * at.vy, rotational * at.vx};
  terms[kDrag] = {-drag * at.vx, -drag * at.vy};
  terms[kDissipation].torque = -(flow.damping + flow.damping_abs * abs(at.w)) * at.w;
  return terms;
}

/// Sum of all terms.
template <class S, std::size_t n>
PlanarForce<S> total(const std::array<PlanarForce<S>, n>& terms) {
  PlanarForce<S> sum = terms[0];
  for (std::size_t k = 1; k < terms.size(); ++k) {
    sum.x = sum.x + terms[k].x;
    sum.y = sum.y + terms[k].y;
    sum.torque = sum.torque + terms[k].torque;
  }
  return sum;
}

/// As wrenches about the point that moves with (vx, vy, w), which is where the torques must be about.
template <class S, std::size_t n>
void to_wrenches(const std::array<PlanarForce<S>, n>& terms, const PlanarMotion<S>& at,
                 LawWrench<S>* wrenches) {
  for (std::size_t k = 0; k < terms.size(); ++k) {
    wrenches[k].force[0] = terms[k].x;
    wrenches[k].force[1] = terms[k].y;
    wrenches[k].torque[2] = terms[k].torque;
    wrenches[k].power = terms[k].x * at.vx + terms[k].y * at.vy + terms[k].torque * at.w;
  }
}

/// Sine and cosine of theta: weight and path need both, and they cost about as much as all else. Of a pack they are the
/// library's, whose last digits depend on the angles in other lanes (batch/lane_sine.h).
template <class S>
struct Heading {
  S sine, cosine;

  explicit Heading(const S* x) : sine(sine_of(x[kTheta])), cosine(cosine_of(x[kTheta])) {}

 private:
  static S sine_of(const S& theta) {
    using std::sin;
    return sin(theta);
  }
  static S cosine_of(const S& theta) {
    using std::cos;
    return cos(theta);
  }
};

/// Attitude and path: theta' = w, and the velocity turned into the world.
template <class S>
void planar_kinematics(const S* x, const Heading<S>& heading, S* dxdt) {
  dxdt[kTheta] = x[kOmega];
  dxdt[kX] = x[kVx] * heading.cosine - x[kVy] * heading.sine;
  dxdt[kY] = x[kVx] * heading.sine + x[kVy] * heading.cosine;
}

/// An elliptic plate about its centre, which is its centre of mass: what is left besides the flow.
template <class S>
struct EllipticPlate {
  S mass_x;   ///< of body and fluid, along x'
  S mass_y;   ///< along y'
  S inertia;  ///< about the centre
  S weight;   ///< less buoyancy
  PlanarFlow<S> flow;

  PlanarForces<S> forces(const S* x, const Heading<S>& heading) const {
    const S& vx = x[kVx];
    const S& vy = x[kVy];
    const S& w = x[kOmega];
    PlanarForces<S> terms = flow_forces(flow, {vx, vy, w});
    terms[kInertia] = {mass_y * w * vy, -mass_x * w * vx, (mass_x - mass_y) * vx * vy};
    terms[kWeight] = {-weight * heading.sine, -weight * heading.cosine};
    return terms;
  }

  void rhs(const S* x, S* dxdt) const {
    const Heading<S> heading(x);
    const PlanarForce<S> sum = total(forces(x, heading));
    dxdt[kVx] = sum.x / mass_x;
    dxdt[kVy] = sum.y / mass_y;
    dxdt[kOmega] = sum.torque / inertia;
    planar_kinematics(x, heading, dxdt);
  }

  S kinetic_energy(const S* x) const {
    return S(0.5) * (mass_x * x[kVx] * x[kVx] + mass_y * x[kVy] * x[kVy] + inertia * x[kOmega] * x[kOmega]);
  }
};

/// U = sqrt(|density/fluid_density - 1| g b) [m/s], b half the thickness or all of it, as the law says.
///
/// |q| is sqrt(q^2 + 1e-24): the same to twelve digits down to differences of density of one in a million,
/// and at equal densities still a speed, with derivatives.
template <class S>
S buoyant_speed(const S& density, const S& fluid_density, const S& g, const S& b) {
  using std::sqrt;
  const S contrast = (density - fluid_density) / fluid_density;
  return sqrt(sqrt(contrast * contrast + S(1e-24)) * g * b);
}

/// The words of planar laws: terms in the order of PlanarTerm, states in that of PlanarState.
std::vector<ForceTermInfo> planar_force_terms();
/// In SI units, at rest with theta = 0.4 rad.
std::vector<StateInfo> planar_states();
/// C_T, C_R, A, B, mu1, mu2 of an elliptic plate, in this order, with the published defaults.
Parameters elliptic_plate_coefficients();
/// fluid_density, by default that of water.
ParameterInfo water();
/// g
ParameterInfo gravity();
inline constexpr const char* kSpeedFloorMeaning =
    "least speed v, which keeps the angle of attack defined at rest";

}  // namespace samara::models::laws
