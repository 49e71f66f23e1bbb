#pragma once

#include <numbers>

#include "samara/models/added_mass/planar_sections.h"
#include "samara/models/laws/planar_plate.h"

namespace samara::models::laws {

/// See info().
struct FallingPlate {
  static constexpr int kStates = kPlanarStates;
  static constexpr int kParameters = 15;
  enum Parameter {
    kSemiChord,
    kSemiThickness,
    kDensity,
    kFluidDensity,
    kG,
    kCT,
    kCR,
    kA,
    kB,
    kMu1,
    kMu2,
    kSpeedFloor,
    kReDrag,
    kReLift,
    kNu
  };

  static ModelInfo info() {
    return {
        .name = "falling_plate",
        .title = "Falling elliptic plate in its plane, per unit span",
        .equations =
            "(m + m11) vx' = (m + m22) w vy - fluid_density G vy - (m - m_f) g sin(theta) - Fx,  "
            "(m + m22) vy' = -(m + m11) w vx + fluid_density G vx - (m - m_f) g cos(theta) - Fy,  "
            "(I + I_a) w' = (m11 - m22) vx vy - pi fluid_density a^4 (mu1 U/a + mu2 |w|) w,  theta' = w,  "
            "x' = vx cos(theta) - vy sin(theta),  y' = vx sin(theta) + vy cos(theta),  "
            "G = (-2 C_T a vx vy/v + 2 C_R a^2 w)/(1 + Re_lift/Re),  "
            "(Fx, Fy) = fluid_density a (1 + Re_drag/Re) (A - B (vx^2 - vy^2)/v^2) v (vx, vy),  "
            "v = sqrt(vx^2 + vy^2 + speed_floor^2),  Re = 2 a v/nu,  U = sqrt(|density/fluid_density - 1| g "
            "b),  "
            "m = pi density a b,  m_f = pi fluid_density a b,  I = m (a^2 + b^2)/4,  "
            "m11 = pi fluid_density b^2,  m22 = pi fluid_density a^2,  "
            "I_a = pi/8 fluid_density (a^2 - b^2)^2,  a = semi_chord,  b = semi_thickness",
        .frames =
            "vx, vy in body axes: x' along the chord, y' along the normal, theta the angle of x' above the "
            "horizontal; x, y in the world, y upward; forces and masses per metre of span",
        .source =
            "A. Andersen, U. Pesavento, Z. J. Wang, Unsteady aerodynamics of fluttering and tumbling "
            "plates, J. Fluid Mech. 541 (2005) 65-90, and Analysis of transitions .., ibid. 91-104; "
            "dissertation, eqs. (2.14)-(2.20), corrected (L of (2.20) is the semi-chord)",
        .validity =
            "motion in a plane, thin plates, Reynolds numbers of about 1e2 to 1e4 (the coefficients are "
            "fitted there); quasi-steady: no wake memory; still, unbounded fluid. In U, |q| is taken as "
            "sqrt(q^2 + 1e-24)",
        .symmetries = {"translation of x", "translation of y", "turn of the body by pi",
                       "reflection: vx, w, theta and x change sign"},
        .states = planar_states(),
        .parameters = parameters(),
        .affine_in = {"C_T", "C_R", "A", "B", "mu1", "mu2"},
        .force_terms = planar_force_terms(),
        .per_span = true,
    };
  }

  static Parameters parameters() {
    Parameters list = {
        positive("semi_chord", "m", "half the chord, a"),
        positive("semi_thickness", "m", "half the thickness, b"),
        positive("density", "kg/m^3", "density of the solid"),
        water(),
        gravity(),
    };
    append(list, elliptic_plate_coefficients());
    list.push_back(derived("speed_floor", "m/s", "1e-6 U", kSpeedFloorMeaning, false));
    append(list, {Re_drag("Re = 2 a v/nu"), Re_lift(), viscosity_of_water()});
    return list;
  }

  template <class S>
  static S characteristic_speed(const S* p) {
    return buoyant_speed(p[kDensity], p[kFluidDensity], p[kG], p[kSemiThickness]);
  }

  template <class S>
  static EllipticPlate<S> plate(const S* p) {
    const S pi = S(std::numbers::pi);
    const S& a = p[kSemiChord];
    const S& b = p[kSemiThickness];
    const S& fluid = p[kFluidDensity];
    const S& solid = p[kDensity];
    const S a2 = a * a;
    const S mass = pi * solid * a * b;
    const added_mass::SectionAddedMass<S> added = added_mass::ellipse_section(a, b, fluid);
    const S lift = S(2.0) * fluid * a;
    const S drag = fluid * a;
    const S damping = pi * fluid * a2 * a;
    return {.mass_x = mass + added.m11,
            .mass_y = mass + added.m22,
            .inertia = S(0.25) * mass * (a2 + b * b) + added.I_a,
            .weight = pi * a * b * (solid - fluid) * p[kG],
            .flow = {.lift_T = lift * p[kCT],
                     .lift_R = lift * a * p[kCR],
                     .drag_chord = drag * (p[kA] - p[kB]),
                     .drag_normal = drag * (p[kA] + p[kB]),
                     .drag_floor = drag * p[kA],
                     .damping = damping * characteristic_speed(p) * p[kMu1],
                     .damping_abs = damping * a * p[kMu2],
                     .speed_floor = p[kSpeedFloor],
                     .Re = reynolds_speeds(p[kReDrag], p[kReLift], p[kNu], S(2.0) * a)}};
  }

  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    plate(p).rhs(x, dxdt);
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    to_wrenches(plate(p).forces(x), {x[kVx], x[kVy], x[kOmega]}, terms);
  }

  template <class S>
  static S kinetic_energy(const S&, const S* x, const S* p) {
    return plate(p).kinetic_energy(x);
  }

  template <class S>
  static void complete(const char* given, S* p) {
    if (!given[kMu2]) p[kMu2] = p[kMu1];
    if (!given[kSpeedFloor]) p[kSpeedFloor] = S(1e-6) * characteristic_speed(p);
  }

  static Scales scales(const double* p) {
    const double speed = characteristic_speed(p);
    return {.length = p[kSemiChord], .time = p[kSemiChord] / speed, .velocity = speed};
  }
};

}  // namespace samara::models::laws
