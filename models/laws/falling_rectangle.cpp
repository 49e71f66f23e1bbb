#include <cmath>

#include <fmt/format.h>

#include "samara/base/number_text.h"
#include "samara/models/added_mass/planar_sections.h"
#include "samara/models/laws/planar_plate.h"

namespace samara::models::laws {

namespace {

struct FallingRectangle {
  static constexpr int kStates = kPlanarStates;
  static constexpr int kParameters = 16;
  enum Parameter {
    kChord,
    kThickness,
    kOffset,
    kDensity,
    kFluidDensity,
    kG,
    kMomentOfInertia,
    kCT,
    kCR,
    kC0,
    kC90,
    kCTau,
    kSpeedFloor,
    kReDrag,
    kReLift,
    kNu
  };

  static ModelInfo info() {
    return {
        .name = "falling_rectangle",
        .title = "Falling rectangular plate in its plane, its mass off centre or not, per unit span",
        .equations =
            "dPx/dt = w Py - fluid_density G v_p - (m - m_f) g sin(theta) - Fx,  "
            "dPy/dt = -w Px + fluid_density G vx - (m - m_f) g cos(theta) - Fy,  "
            "dL/dt = m11 vx vy - m22 vx v_p - offset (fluid_density G vx - Fy + m_f g cos(theta)) - C_tau "
            "fluid_density a^4 |w| w/64,  Px = (m + m11) vx,  Py = m vy + m22 v_p,  "
            "L = (moment_of_inertia + I_a) w - offset m22 v_p,  v_p = vy - offset w,  theta' = w,  "
            "x' = vx cos(theta) - vy sin(theta),  y' = vx sin(theta) + vy cos(theta),  "
            "G = (-C_T a vx v_p/v + C_R a^2 w/2)/(1 + Re_lift/Re),  "
            "(Fx, Fy) = 1/2 fluid_density a (1 + Re_drag/Re) (C_0 vx^2 + C_90 v_p^2)/v (vx, v_p),  "
            "v = sqrt(vx^2 + v_p^2 + speed_floor^2),  Re = a v/nu,  m = density a b,  m_f = fluid_density a "
            "b,  "
            "m11 = 3 pi/8 fluid_density b^2,  m22 = 3 pi/8 fluid_density a^2,  "
            "I_a = 5 pi/256 fluid_density (a^2 - b^2)^2,  a = chord,  b = thickness",
        .frames =
            "vx, vy are the velocity of the centre of mass in body axes: x' along the chord, y' along the "
            "normal, theta the angle of x' above the horizontal; the centre of mass lies at x' = offset "
            "from the plate's centre; x, y are its place in the world, y upward; forces and masses per "
            "metre of span",
        .source =
            "W. Huang, H. Liu, F. Wang, J. Wu, H. P. Zhang, Experimental study of a freely falling plate "
            "with an inhomogeneous mass distribution, Phys. Rev. E 88 (2013) 053008, for the coefficients; "
            "A. Andersen, U. Pesavento, Z. J. Wang, J. Fluid Mech. 541 (2005) 65-90, for the form. Lift, "
            "drag, added mass and buoyancy act at the plate's centre, so that no force makes energy",
        .validity =
            "motion in a plane, Reynolds numbers of about 1e3 (coefficients fitted at 1.5e3); "
            "quasi-steady: no wake memory; still, unbounded fluid. C_0 and C_90 are taken on 1/2 "
            "fluid_density chord v^2",
        .symmetries = {"translation of x", "translation of y"},
        .states = planar_states(),
        .parameters = parameters(),
        .affine_in = {"C_T", "C_R", "C_0", "C_90", "C_tau"},
        .force_terms = planar_force_terms(),
        .per_span = true,
    };
  }

  static Parameters parameters() {
    return {
        positive("chord", "m", "full chord, a"),
        positive("thickness", "m", "full thickness, b"),
        any_value("offset", "m", 0.0, "of the centre of mass from the plate's centre, along x'"),
        positive("density", "kg/m^3", "mean density of the solid"),
        water(),
        gravity(),
        derived("moment_of_inertia", "kg m", "density a b (a^2 + b^2)/12",
                "of the solid about its centre of mass; default: of even density", false),
        any_value("C_T", "1", 4.5, "translational lift"),
        any_value("C_R", "1", 1.8, "rotational lift"),
        not_negative("C_0", "1", 0.2, "drag edge-on"),
        not_negative("C_90", "1", 0.5, "drag broadside"),
        not_negative("C_tau", "1", 1.9, "dissipation of rotation"),
        derived("speed_floor", "m/s", "1e-6 sqrt(|density/fluid_density - 1| g b)", kSpeedFloorMeaning,
                false),
        Re_drag("Re = chord v/nu"),
        Re_lift(),
        viscosity_of_water(),
    };
  }

  template <class S>
  struct Plate {
    S offset;
    S mass;     ///< of the solid
    S moment;   ///< of inertia, of the solid about its centre of mass
    S added_x;  ///< added mass and moment, about the plate's centre
    S added_y;
    S added_moment;
    S weight;  ///< of the solid
    S buoyancy;
    PlanarFlow<S> flow;
  };

  template <class S>
  static Plate<S> plate(const S* p) {
    const S& a = p[kChord];
    const S& b = p[kThickness];
    const S& fluid = p[kFluidDensity];
    const S a2 = a * a;
    const added_mass::SectionAddedMass<S> added = added_mass::rectangle_section(a, b, fluid);
    const S mass = p[kDensity] * a * b;
    const S half = S(0.5) * fluid * a;
    return {.offset = p[kOffset],
            .mass = mass,
            .moment = p[kMomentOfInertia],
            .added_x = added.m11,
            .added_y = added.m22,
            .added_moment = added.I_a,
            .weight = mass * p[kG],
            .buoyancy = fluid * a * b * p[kG],
            .flow = {.lift_T = fluid * a * p[kCT],
                     .lift_R = S(0.5) * fluid * a2 * p[kCR],
                     .drag_chord = half * p[kC0],
                     .drag_normal = half * p[kC90],
                     .drag_floor = S(0.0),
                     .damping = S(0.0),
                     .damping_abs = S(1.0 / 64.0) * fluid * a2 * a2 * p[kCTau],
                     .speed_floor = p[kSpeedFloor],
                     .Re = reynolds_speeds(p[kReDrag], p[kReLift], p[kNu], a)}};
  }

  /// Forces, with torques about the centre of mass.
  template <class S>
  static PlanarForces<S> force_terms(const Plate<S>& plate, const S* x, const Heading<S>& heading) {
    const S& vx = x[kVx];
    const S& vy = x[kVy];
    const S& w = x[kOmega];
    const S vp = vy - plate.offset * w;
    PlanarForces<S> terms = flow_forces(plate.flow, {vx, vp, w});
    for (PlanarForce<S>& term : terms) term.torque = term.torque - plate.offset * term.y;
    terms[kInertia] = {w * (plate.mass * vy + plate.added_y * vp), -w * (plate.mass + plate.added_x) * vx,
                       vx * (plate.added_x * vy - plate.added_y * vp)};
    const S force = plate.buoyancy - plate.weight;
    const S& c = heading.cosine;
    terms[kWeight] = {force * heading.sine, force * c, -plate.offset * plate.buoyancy * c};
    return terms;
  }

  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    const Plate<S> body = plate(p);
    const Heading<S> heading(x);
    const PlanarForce<S> sum = total(force_terms(body, x, heading));
    // Momentum across the chord and angular momentum are coupled by the offset:
    //   mass_y vy' - coupling w' = force,  -coupling vy' + moment w' = torque.
    const S coupling = body.offset * body.added_y;
    const S mass_y = body.mass + body.added_y;
    const S moment = body.moment + body.added_moment + body.offset * coupling;
    const S determinant = mass_y * moment - coupling * coupling;
    dxdt[kVx] = sum.x / (body.mass + body.added_x);
    dxdt[kVy] = (moment * sum.y + coupling * sum.torque) / determinant;
    dxdt[kOmega] = (coupling * sum.y + mass_y * sum.torque) / determinant;
    planar_kinematics(x, heading, dxdt);
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    to_wrenches(force_terms(plate(p), x, Heading<S>(x)), {x[kVx], x[kVy], x[kOmega]}, terms);
  }

  template <class S>
  static S kinetic_energy(const S&, const S* x, const S* p) {
    const Plate<S> body = plate(p);
    const S& vx = x[kVx];
    const S& vy = x[kVy];
    const S& w = x[kOmega];
    const S vp = vy - body.offset * w;
    return S(0.5) * ((body.mass + body.added_x) * vx * vx + body.mass * vy * vy + body.added_y * vp * vp +
                     (body.moment + body.added_moment) * w * w);
  }

  template <class S>
  static S characteristic_speed(const S* p) {
    return buoyant_speed(p[kDensity], p[kFluidDensity], p[kG], p[kThickness]);
  }

  template <class S>
  static void complete(const char* given, S* p) {
    const S& a = p[kChord];
    const S& b = p[kThickness];
    if (!given[kMomentOfInertia]) {
      p[kMomentOfInertia] = S(1.0 / 12.0) * p[kDensity] * a * b * (a * a + b * b);
    }
    if (!given[kSpeedFloor]) p[kSpeedFloor] = S(1e-6) * characteristic_speed(p);
  }

  static std::string problem(const double* p) {
    if (std::abs(p[kOffset]) <= 0.5 * p[kChord]) return "";
    return fmt::format(
        "offset is {} m; a centre of mass on the plate was expected, at most {} m off its centre",
        number_text(p[kOffset]), number_text(0.5 * p[kChord]));
  }

  static Scales scales(const double* p) {
    const double speed = characteristic_speed(p);
    return {.length = p[kChord], .time = p[kChord] / speed, .velocity = speed};
  }
};

}  // namespace

std::shared_ptr<const Model> falling_rectangle() {
  return std::make_shared<LawModel<FallingRectangle>>();
}

}  // namespace samara::models::laws
