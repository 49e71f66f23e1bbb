#pragma once

#include <numbers>

#include "samara/models/added_mass/planar_sections.h"
#include "samara/models/laws/planar_plate.h"

namespace samara::models::laws {

/// The elliptic plate of falling_plate, and of the laws that add to it: its parameters come first among theirs.
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

  static ModelInfo info();
  static Parameters parameters();

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
    to_wrenches(plate(p).forces(x, Heading<S>(x)), {x[kVx], x[kVy], x[kOmega]}, terms);
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
