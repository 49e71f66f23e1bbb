#include <cmath>
#include <numbers>

#include "samara/models/laws/planar_plate.h"

namespace samara::models::laws {

namespace {

struct FallingPlateLinearDrag {
  static constexpr int kStates = 6;
  static constexpr int kParameters = 7;
  enum State { kU, kV, kW, kAngle, kPlaceX, kPlaceY };
  enum Parameter { kAPerp, kAPar, kChord, kMass, kFluidDensity, kG, kSignFloor };
  enum Term { kGyroscopic, kLinearDrag, kLift, kMoment, kRotationDrag, kGravity, kTerms };

  static ModelInfo info() {
    return {
        .name = "falling_plate_linear_drag",
        .title = "Falling paper with linear drag (Tanabe, Kaneko), per unit span",
        .equations =
            "u' = -(A_perp s^2 + A_par c^2) u + (A_perp - A_par) s c v - k L vn v,  "
            "v' = -(A_perp c^2 + A_par s^2) v + (A_perp - A_par) s c u + k L vn u - g,  "
            "w' = -A_perp w - 3 pi fluid_density vn vt/mass,  theta' = w,  x' = u,  y' = v,  "
            "s = sin(theta),  c = cos(theta),  vt = u c + v s,  vn = v c - u s,  "
            "L = pi fluid_density chord/mass,  "
            "k = sign(v) sign(vt),  sign(q) = q/sqrt(q^2 + sign_floor^2)",
        .frames =
            "u, v and x, y in the world, x horizontal, y upward; theta the angle of the chord above the "
            "horizontal; vt, vn the velocity along chord and normal. With alpha = atan2(u, v) and beta = "
            "alpha + theta of the source, vn = V cos(beta) and vt = V sin(beta)",
        .source =
            "Y. Tanabe, K. Kaneko, Behavior of a falling paper, Phys. Rev. Lett. 73 (1994) 1372-1375; "
            "dissertation, eqs. (3.4)-(3.5), with gravity in v' and 1/mass in w', which (3.4) omits",
        .validity =
            "a rule for pictures of falling paper: neither added mass nor buoyancy nor quadratic drag. The "
            "source's k is +1 or -1 and jumps where v or vt changes sign; here it does so within "
            "sign_floor. Much smaller than its default the motion may slide along the jump, where "
            "integrators stop. The lift has its right sign for falling bodies only (v < 0). The drag is "
            "linear "
            "as it stands: no coefficient depends on a Reynolds number",
        .symmetries = {"translation of x", "translation of y"},
        .states = states(),
        .parameters = parameters(),
        .affine_in = {"A_perp", "A_par", "g"},
        .force_terms = force_terms(),
        .per_span = true,
    };
  }

  static std::vector<StateInfo> states() {
    return {
        {.name = "u", .unit = "m/s", .description = "horizontal velocity"},
        {.name = "v", .unit = "m/s", .description = "vertical velocity, positive upward"},
        {.name = "w", .unit = "rad/s", .description = "rotation rate, theta'"},
        {.name = "theta",
         .unit = "rad",
         .default_initial = 0.4,
         .description = "angle of the chord above the horizontal"},
        {.name = "x", .unit = "m", .description = "horizontal position"},
        {.name = "y", .unit = "m", .description = "height, positive upward"},
    };
  }

  static Parameters parameters() {
    return {
        not_negative("A_perp", "1/s", 4.1, "drag along the normal, and of rotation, over mass"),
        not_negative("A_par", "1/s", 0.9,
                     "drag along the chord, over mass; defaults: fluttering, dissertation figure 3.4 (a)"),
        positive("chord", "m", "full chord"),
        positive("mass", "kg/m", "mass per unit span"),
        with_default(positive("fluid_density", "kg/m^3", "density of the fluid; default: air"), 1.23),
        gravity(),
        derived("sign_floor", "m/s", "0.02 sqrt(g mass/(pi fluid_density chord))",
                "speed within which k changes its sign", false),
    };
  }

  static std::vector<ForceTermInfo> force_terms() {
    return {
        {.name = "inertia", .description = "of the body, from turning axes; no power"},
        {.name = "drag", .description = "linear in the velocity; takes power"},
        {.name = "lift",
         .description = "of Kutta and Joukowski, k pi fluid_density chord V^2 cos(beta); no power"},
        {.name = "moment", .description = "of the lift at a quarter chord"},
        {.name = "dissipation", .description = "torque against the rotation; takes power"},
        {.name = "gravity", .description = "weight"},
    };
  }

  /// The motion in body axes, and the attitude.
  template <class S>
  struct Motion {
    S s, c;
    S vt, vn;
  };

  template <class S>
  static Motion<S> motion(const S* x) {
    using std::cos;
    using std::sin;
    const S s = sin(x[kAngle]);
    const S c = cos(x[kAngle]);
    return {s, c, x[kU] * c + x[kV] * s, x[kV] * c - x[kU] * s};
  }

  template <class S>
  static S smooth_sign(const S& q, const S& floor) {
    using std::sqrt;
    return q / sqrt(q * q + floor * floor);
  }

  template <class S>
  static S moment_of_inertia(const S* p) {
    return S(1.0 / 12.0) * p[kMass] * p[kChord] * p[kChord];
  }

  template <class S>
  static std::array<PlanarForce<S>, kTerms> force_list(const Motion<S>& at, const S* x, const S* p) {
    const S& mass = p[kMass];
    const S& w = x[kW];
    const S k = smooth_sign(x[kV], p[kSignFloor]) * smooth_sign(at.vt, p[kSignFloor]);
    const S lift = k * S(std::numbers::pi) * p[kFluidDensity] * p[kChord] * at.vn;
    const S quarter = S(0.25 * std::numbers::pi) * p[kFluidDensity] * p[kChord] * p[kChord];
    std::array<PlanarForce<S>, kTerms> terms;
    terms[kGyroscopic] = {mass * w * at.vn, -mass * w * at.vt};
    terms[kLinearDrag] = {-mass * p[kAPar] * at.vt, -mass * p[kAPerp] * at.vn};
    terms[kLift] = {-lift * at.vn, lift * at.vt};
    terms[kMoment].torque = -quarter * at.vn * at.vt;
    terms[kRotationDrag].torque = -p[kAPerp] * moment_of_inertia(p) * w;
    terms[kGravity] = {-mass * p[kG] * at.s, -mass * p[kG] * at.c};
    return terms;
  }

  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    const Motion<S> at = motion(x);
    std::array<PlanarForce<S>, kTerms> terms = force_list(at, x, p);
    terms[kGyroscopic] = {};  // the rates are those of world components
    const PlanarForce<S> sum = total(terms);
    dxdt[kU] = (sum.x * at.c - sum.y * at.s) / p[kMass];
    dxdt[kV] = (sum.x * at.s + sum.y * at.c) / p[kMass];
    dxdt[kW] = sum.torque / moment_of_inertia(p);
    dxdt[kAngle] = x[kW];
    dxdt[kPlaceX] = x[kU];
    dxdt[kPlaceY] = x[kV];
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    const Motion<S> at = motion(x);
    to_wrenches(force_list(at, x, p), {at.vt, at.vn, x[kW]}, terms);
  }

  template <class S>
  static S kinetic_energy(const S&, const S* x, const S* p) {
    return S(0.5) * (p[kMass] * (x[kU] * x[kU] + x[kV] * x[kV]) + moment_of_inertia(p) * x[kW] * x[kW]);
  }

  /// The length on which the lift turns the path [m].
  template <class S>
  static S turning_length(const S* p) {
    return p[kMass] / (S(std::numbers::pi) * p[kFluidDensity] * p[kChord]);
  }

  template <class S>
  static void complete(const char* given, S* p) {
    using std::sqrt;
    if (!given[kSignFloor]) p[kSignFloor] = S(0.02) * sqrt(p[kG] * turning_length(p));
  }

  static Scales scales(const double* p) {
    const double length = turning_length(p);
    const double velocity = std::sqrt(p[kG] * length);
    return {.length = length, .time = length / velocity, .velocity = velocity};
  }
};

}  // namespace

std::shared_ptr<const Model> falling_plate_linear_drag() {
  return std::make_shared<LawModel<FallingPlateLinearDrag>>();
}

}  // namespace samara::models::laws
