#pragma once

#include <algorithm>
#include <array>

#include "samara/models/law_tools/reynolds.h"
#include "samara/models/laws/rigid_body.h"

namespace samara::models::laws {

/// See info().
struct SphereFlight {
  static constexpr int kStates = 9;
  enum State { kPosition, kV = 3, kW = 6 };
  enum Parameter {
    kDiameter,
    kMass,
    kCD,
    kCM,
    kFluidDensity,
    kG,
    kSpinDecay,
    kSpeedFloor,
    kDisplacedMass,
    kAddedMass,
    kInertia,
    kReDrag,
    kNu,
    kMagnusSaturation,
    kSpinDrag,
    kParameters
  };
  enum Term { kDrag, kMagnus, kDamping, kGravity, kTerms };

  static ModelInfo info() {
    return {
        .name = "sphere_flight",
        .title = "Spinning sphere in flight",
        .equations =
            "(m + m_a) v' = -1/2 rho A (C_D (1 + Re_drag/Re) + spin_drag S) V v + 1/2 rho A C_M r w x v/(1 + "
            "magnus_saturation S) + (m - m_f) (0, 0, -g);  "
            "(x, y, z)' = v;  "
            "w' = -spin_decay w;  "
            "V = sqrt(|v|^2 + speed_floor^2);  "
            "S = sqrt(r^2 |w|^2 + speed_floor^2)/V;  "
            "Re = diameter V/nu;  "
            "A = pi r^2;  "
            "r = diameter/2;  "
            "rho = fluid_density;  "
            "m = mass;  "
            "m_a = added_mass;  "
            "m_f = displaced_mass",
        .frames = "world: z up; all vectors in world axes, forces and torques too",
        .source =
            "R. D. Mehta, Aerodynamics of sports balls, Annu. Rev. Fluid Mech. 17 (1985) 151-189; lift of a "
            "spinning sphere proportional to r w/|v| as in A. M. Nathan, Am. J. Phys. 76 (2008) 119-124; "
            "added mass m_f/2: H. Lamb, Hydrodynamics, 6th ed., 1932, art. 92",
        .validity =
            "r |w| / |v| up to about 0.5 (beyond with magnus_saturation), a Reynolds number (diameter) of "
            "about 1e3 to 1e5 away from the "
            "drag crisis; smooth spheres at low spin may show the reverse of the Magnus force. At small "
            "Reynolds number Re_drag = 24/C_D gives Stokes' drag, and C_M = 2 (S. I. Rubinow, J. B. Keller, "
            "J. Fluid Mech. 11 (1961) 447-459): it does not vanish, so that C_M is a constant here",
        .symmetries = upright_symmetries(),
        .states = states(),
        .parameters = parameters(),
        .affine_in = {"C_D", "C_M", "g", "spin_decay", "spin_drag"},
        .force_terms = {{.name = "drag", .description = "against v"},
                        {.name = "Magnus", .description = "perpendicular to v and to the spin"},
                        {.name = "damping", .description = "of the spin"},
                        {.name = "gravity and buoyancy", .description = "at the centre"}},
        .groups = {{.kind = StateGroupKind::position, .first = kPosition},
                   {.kind = StateGroupKind::vector, .first = kV},
                   {.kind = StateGroupKind::vector, .first = kW}},
    };
  }

  static std::vector<StateInfo> states() {
    return {
        {.name = "x", .unit = "m", .description = "position of the centre"},
        {.name = "y", .unit = "m", .description = "position of the centre"},
        {.name = "z", .unit = "m", .description = "position of the centre, up"},
        {.name = "vx", .unit = "m/s", .description = "velocity along x"},
        {.name = "vy", .unit = "m/s", .description = "velocity along y"},
        {.name = "vz", .unit = "m/s", .description = "velocity along z"},
        {.name = "wx", .unit = "rad/s", .description = "spin about x"},
        {.name = "wy", .unit = "rad/s", .description = "spin about y"},
        {.name = "wz", .unit = "rad/s", .description = "spin about z"},
    };
  }

  static Parameters parameters() {
    return {
        with_default(
            positive("diameter", "m", "diameter; default: table-tennis ball (ITTF laws of the game)"), 0.04),
        with_default(positive("mass", "kg", "mass; default: table-tennis ball (ITTF laws of the game)"),
                     2.7e-3),
        not_negative("C_D", "1", 0.45,
                     "drag coefficient on pi r^2; default: smooth sphere below the drag crisis"),
        any_value("C_M", "1", 1.0,
                  "slope of the lift coefficient, C_L = C_M S / (1 + magnus_saturation S), S = r |w| / |v|; "
                  "default: about what balls have at r |w| / |v| of 0.1 to 0.3"),
        with_default(positive("fluid_density", "kg/m^3",
                              "density of the fluid; default: air at 20 degrees C and 1 atm, rounded"),
                     1.2),
        not_negative("g", "m/s^2", 9.81, "gravitational acceleration"),
        not_negative("spin_decay", "1/s", 0.0, "rate at which the spin decays"),
        with_default(positive("speed_floor", "m/s", "speed below which the drag is smoothed"), 1e-3),
        derived("displaced_mass", "kg", "pi/6 fluid_density diameter^3", "mass of the displaced fluid", true),
        derived("added_mass", "kg", "displaced_mass / 2", "added mass", true),
        derived("inertia", "kg m^2", "mass diameter^2 / 6", "moment of inertia; default: thin shell", false),
        Re_drag("Re = diameter |v|/nu"),
        viscosity_of_air(),
        not_negative("magnus_saturation", "1", 0.0,
                     "how the lift coefficient falls below its slope: at S = 1/magnus_saturation it is half "
                     "of it"),
        any_value("spin_drag", "1", 0.0, "how much the drag coefficient grows with S"),
    };
  }

  template <class S>
  static std::array<Load<S>, kTerms> loads(const Vector3<S>& v, const Vector3<S>& w, const S* p) {
    using std::sqrt;
    const S radius = S(0.5) * p[kDiameter];
    const S half_rho_A = S(0.5 * std::numbers::pi) * p[kFluidDensity] * radius * radius;
    const S speed = sqrt(dot(v, v) + p[kSpeedFloor] * p[kSpeedFloor]);
    const ReynoldsSpeeds<S> Re = reynolds_speeds(p[kReDrag], S(0.0), p[kNu], p[kDiameter]);
    // The rim needs a floor of its own, or |w| had no derivative at rest.
    const S rim = sqrt(radius * radius * dot(w, w) + p[kSpeedFloor] * p[kSpeedFloor]);
    const S drag = p[kCD] * drag_speed(speed, Re.drag) + p[kSpinDrag] * rim;
    const S lift = p[kCM] * speed / (speed + p[kMagnusSaturation] * rim);
    const Vector3<S> weight = {S(0.0), S(0.0), -(p[kMass] - p[kDisplacedMass]) * p[kG]};
    return {{{-(half_rho_A * drag) * v, {}},
             {(half_rho_A * lift * radius) * cross(w, v), {}},
             {{}, -(p[kInertia] * p[kSpinDecay]) * w},
             {weight, {}}}};
  }

  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    Load<S> sum;
    for (const Load<S>& load : loads(vector3(x + kV), vector3(x + kW), p)) sum = sum + load;
    store(vector3(x + kV), dxdt + kPosition);
    store((S(1.0) / (p[kMass] + p[kAddedMass])) * sum.force, dxdt + kV);
    store((S(1.0) / p[kInertia]) * sum.torque, dxdt + kW);
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    const Vector3<S> v = vector3(x + kV);
    const Vector3<S> w = vector3(x + kW);
    const std::array<Load<S>, kTerms> all = loads(v, w, p);
    for (std::size_t k = 0; k < all.size(); ++k) terms[k] = wrench(all[k], v, w);
  }

  template <class S>
  static S kinetic_energy(const S&, const S* x, const S* p) {
    const Vector3<S> v = vector3(x + kV);
    const Vector3<S> w = vector3(x + kW);
    return S(0.5) * ((p[kMass] + p[kAddedMass]) * dot(v, v) + p[kInertia] * dot(w, w));
  }

  template <class S>
  static void complete(const char* given, S* p) {
    const S& d = p[kDiameter];
    if (!given[kDisplacedMass]) p[kDisplacedMass] = S(std::numbers::pi / 6.0) * p[kFluidDensity] * d * d * d;
    if (!given[kAddedMass]) p[kAddedMass] = S(0.5) * p[kDisplacedMass];
    if (!given[kInertia]) p[kInertia] = p[kMass] * d * d / S(6.0);
  }

  static Scales scales(const double* p) {
    const double k = 0.125 * std::numbers::pi * p[kFluidDensity] * p[kDiameter] * p[kDiameter] *
                     std::max(kLeastDragCoefficient, p[kCD]);
    return body_scales(p[kDiameter], (p[kMass] - p[kDisplacedMass]) * p[kG], p[kMass], k);
  }
};

}  // namespace samara::models::laws
