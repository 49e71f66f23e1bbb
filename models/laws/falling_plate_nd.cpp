#include <numbers>

#include "samara/models/laws/planar_plate.h"

namespace samara::models::laws {

namespace {

struct FallingPlateNd {
  static constexpr int kStates = kPlanarStates;
  static constexpr int kParameters = 12;
  enum Parameter { kInertiaRatio, kBeta, kCT, kCR, kA, kB, kMu1, kMu2, kSpeedFloor, kReDrag, kReLift, kRe };

  static ModelInfo info() {
    return {
        .name = "falling_plate_nd",
        .title = "Falling elliptic plate in its plane, dimensionless",
        .equations =
            "(I + beta^2) vx' = (I + 1) w vy - G vy - sin(theta) - Fx,  "
            "(I + 1) vy' = -(I + beta^2) w vx + G vx - cos(theta) - Fy,  "
            "1/4 [I (1 + beta^2) + (1 - beta^2)^2/2] w' = -(1 - beta^2) vx vy - (mu1 + mu2 |w|) w,  "
            "theta' = w,  x' = vx cos(theta) - vy sin(theta),  y' = vx sin(theta) + vy cos(theta),  "
            "G = 2/pi (-C_T vx vy/v + C_R w)/(1 + Re_lift/(Re v)),  "
            "(Fx, Fy) = 1/pi (1 + Re_drag/(Re v)) (A - B (vx^2 - vy^2)/v^2) v (vx, vy),  "
            "v = sqrt(vx^2 + vy^2 + speed_floor^2),  I = inertia_ratio",
        .frames =
            "vx, vy in body axes: x' along the chord, y' along the normal, theta the angle of x' above the "
            "horizontal; x, y in the world, y upward. Units: length the semi-chord a, velocity U = "
            "sqrt((density/fluid_density - 1) g b) with the semi-thickness b, mass pi fluid_density a^2 "
            "per unit span",
        .source =
            "A. Andersen, U. Pesavento, Z. J. Wang, Analysis of transitions between fluttering, tumbling "
            "and steady descent of falling cards, J. Fluid Mech. 541 (2005) 91-104, with the added mass "
            "and inertia of an ellipse of finite thickness; dissertation, eqs. (2.14)-(2.20), corrected",
        .validity =
            "motion in a plane, thin plates heavier than the fluid, Reynolds numbers of about 1e2 to 1e4 "
            "(the coefficients are fitted there); quasi-steady: no wake memory; still, unbounded fluid. "
            "beta = 0 is the thin limit",
        .symmetries = {"translation of x", "translation of y", "turn of the body by pi",
                       "reflection: vx, w, theta and x change sign"},
        .states = states(),
        .parameters = parameters(),
        .affine_in = {"C_T", "C_R", "A", "B", "mu1", "mu2"},
        .force_terms = planar_force_terms(),
        .per_span = true,
    };
  }

  static std::vector<StateInfo> states() {
    std::vector<StateInfo> states = planar_states();
    for (StateInfo& state : states) state.unit = std::string("1");
    // Off the rest, where the angle of attack has no meaning.
    states[kVx].default_initial = 1e-3;
    states[kVy].default_initial = 1e-3;
    return states;
  }

  static Parameters parameters() {
    Parameters list = {
        with_default(positive("inertia_ratio", "1", "I* = density b/(fluid_density a)"), 1.1),
        not_negative("beta", "1", 1.0 / 14.0, "thickness over chord, b/a"),
    };
    append(list, elliptic_plate_coefficients());
    list.push_back(with_default(positive("speed_floor", "1", kSpeedFloorMeaning), 1e-6));
    append(list,
           {Re_drag("at the Reynolds number Re v"), Re_lift(),
            with_default(positive("Re", "1", "Reynolds number of the unit of velocity, 2 a U/nu"), 1e3)});
    return list;
  }

  template <class S>
  static EllipticPlate<S> plate(const S* p) {
    const S& ratio = p[kInertiaRatio];
    const S beta2 = p[kBeta] * p[kBeta];
    const S thin = S(1.0) - beta2;
    const S lift = S(2.0 / std::numbers::pi);
    const S drag = S(1.0 / std::numbers::pi);
    return {.mass_x = ratio + beta2,
            .mass_y = ratio + S(1.0),
            .inertia = S(0.25) * (ratio * (S(1.0) + beta2) + S(0.5) * thin * thin),
            .weight = S(1.0),
            .flow = {.lift_T = lift * p[kCT],
                     .lift_R = lift * p[kCR],
                     .drag_chord = drag * (p[kA] - p[kB]),
                     .drag_normal = drag * (p[kA] + p[kB]),
                     .drag_floor = drag * p[kA],
                     .damping = p[kMu1],
                     .damping_abs = p[kMu2],
                     .speed_floor = p[kSpeedFloor],
                     .Re = reynolds_speeds(p[kReDrag], p[kReLift], S(1.0), p[kRe])}};
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
  }

  static Scales scales(const double*) { return {}; }
};

}  // namespace

std::shared_ptr<const Model> falling_plate_nd() {
  return std::make_shared<LawModel<FallingPlateNd>>();
}

}  // namespace samara::models::laws
