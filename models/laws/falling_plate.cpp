#include "samara/models/laws/falling_plate.h"

#include "samara/models/batch/lane_sine.h"

namespace samara::models::laws {

ModelInfo FallingPlate::info() {
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
          "v = sqrt(vx^2 + vy^2 + speed_floor^2),  Re = 2 a v/nu,  "
          "U = sqrt(|density/fluid_density - 1| g b),  m = pi density a b,  "
          "m_f = pi fluid_density a b,  I = m (a^2 + b^2)/4,  m11 = pi fluid_density b^2,  "
          "m22 = pi fluid_density a^2,  I_a = pi/8 fluid_density (a^2 - b^2)^2,  a = semi_chord,  "
          "b = semi_thickness",
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

Parameters FallingPlate::parameters() {
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

namespace {

/// The plate in a fluid that accelerates and changes by a gradient: the equations of falling_plate for the velocity
/// relative to it, with the pressure gradient and the inertia of that acceleration, and what the gradient does to the
/// added mass (gradient_force() of ambient_policies.h, in the plane).
struct FallingPlateInGusts {
  static constexpr int kStates = kPlanarStates;
  enum Parameter {
    kStart = FallingPlate::kParameters,
    kGust,
    kRate = kGust + 2,
    kGradient = kRate + 2,  ///< xx, xy, yx, yy
    kSpin = kGradient + 4,
    kParameters
  };
  /// The last one is that of the fluid's acceleration.
  static constexpr std::size_t kTerms = kPlanarTerms + 1;

  static ModelInfo info() {
    ModelInfo info = FallingPlate::info();
    info.name = "falling_plate_in_gusts";
    info.title = "Falling elliptic plate in its plane, in a fluid that changes in time, per unit span";
    info.equations =
        "(m + m11) ux' = (m + m22) w uy - fluid_density G uy - (m - m_f) g sin(theta) - Fx + Hx cos(theta) + "
        "Hy sin(theta),  "
        "(m + m22) uy' = -(m + m11) w ux + fluid_density G ux - (m - m_f) g cos(theta) - Fy + "
        "Hy cos(theta) - Hx sin(theta),  "
        "(I + I_a) w' = (m11 - m22) ux uy - pi fluid_density a^4 (mu1 U/a + mu2 |w_r|) w_r,  theta' = w,  "
        "x' = vx cos(theta) - vy sin(theta),  y' = vx sin(theta) + vy cos(theta),  "
        "ux = vx - Wx cos(theta) - Wy sin(theta),  uy = vy + Wx sin(theta) - Wy cos(theta),  "
        "w_r = w - gust_spin,  Wx = gust_x + (t - gust_start) gust_rate_x,  "
        "Wy = gust_y + (t - gust_start) gust_rate_y,  "
        "Hx = (m_f - m) gust_rate_x - gust_gradient_xx (m_f Sx + Qx) - gust_gradient_xy m_f Sy - "
        "gust_gradient_yx Qy,  "
        "Hy = (m_f - m) gust_rate_y - gust_gradient_yy (m_f Sy + Qy) - gust_gradient_yx m_f Sx - "
        "gust_gradient_xy Qx,  "
        "Sx = ux cos(theta) - uy sin(theta),  Sy = ux sin(theta) + uy cos(theta),  "
        "Qx = m11 ux cos(theta) - m22 uy sin(theta),  Qy = m11 ux sin(theta) + m22 uy cos(theta),  "
        "G = (-2 C_T a ux uy/v + 2 C_R a^2 w_r)/(1 + Re_lift/Re),  "
        "(Fx, Fy) = fluid_density a (1 + Re_drag/Re) (A - B (ux^2 - uy^2)/v^2) v (ux, uy),  "
        "v = sqrt(ux^2 + uy^2 + speed_floor^2),  Re = 2 a v/nu,  "
        "U = sqrt(|density/fluid_density - 1| g b),  m = pi density a b,  m_f = pi fluid_density a b,  "
        "I = m (a^2 + b^2)/4,  m11 = pi fluid_density b^2,  m22 = pi fluid_density a^2,  "
        "I_a = pi/8 fluid_density (a^2 - b^2)^2,  a = semi_chord,  b = semi_thickness";
    info.validity +=
        ". The fluid changes little over the chord. Realisations (samara simulate --realisations) set the "
        "gust step by step; by itself it is one ramp in time";
    info.symmetries = {"translation of x", "translation of y", "turn of the body by pi"};
    append(info.parameters,
           {any_value("gust_start", "s", 0.0, "time at which the velocity is (gust_x, gust_y)"),
            any_value("gust_x", "m/s", 0.0, "velocity of the fluid at gust_start"),
            any_value("gust_y", "m/s", 0.0, "velocity of the fluid at gust_start, upward"),
            any_value("gust_rate_x", "m/s^2", 0.0, "its rate along the path of the plate"),
            any_value("gust_rate_y", "m/s^2", 0.0, "its rate along the path of the plate"),
            any_value("gust_gradient_xx", "1/s", 0.0, "change of its x component along x"),
            any_value("gust_gradient_xy", "1/s", 0.0, "change of its x component along y"),
            any_value("gust_gradient_yx", "1/s", 0.0, "change of its y component along x"),
            any_value("gust_gradient_yy", "1/s", 0.0, "change of its y component along y"),
            any_value("gust_spin", "rad/s", 0.0, "angular velocity of the fluid, in the sense of theta")});
    info.force_terms[kDissipation].description = "torque against the rotation relative to the fluid";
    info.force_terms.push_back({.name = "ambient acceleration",
                                .description =
                                    "pressure gradient of the undisturbed fluid, less the mass times "
                                    "the rate of its velocity along the path, and what its gradient does "
                                    "to the added mass; takes or gives power"});
    return info;
  }

  /// A vector along the chord and the normal.
  template <class S>
  struct Along {
    S x, y;
  };

  template <class S>
  struct Air {
    Along<S> velocity, rate;  ///< in body axes
    S xx, xy, yx, yy;         ///< the gradient in body axes

    Air(const S& t, const S& s, const S& c, const S* p) {
      const auto turned = [&](const S& X, const S& Y) { return Along<S>{X * c + Y * s, Y * c - X * s}; };
      const S dt = t - p[kStart];
      velocity = turned(p[kGust] + dt * p[kRate], p[kGust + 1] + dt * p[kRate + 1]);
      rate = turned(p[kRate], p[kRate + 1]);
      const S* G = p + kGradient;
      const Along<S> along_chord = turned(G[0] * c + G[1] * s, G[2] * c + G[3] * s);
      const Along<S> along_normal = turned(G[1] * c - G[0] * s, G[3] * c - G[2] * s);
      xx = along_chord.x, yx = along_chord.y;
      xy = along_normal.x, yy = along_normal.y;
    }
  };

  template <class S>
  static std::array<PlanarForce<S>, kTerms> terms_of(const EllipticPlate<S>& plate, const PlanarMotion<S>& u,
                                                     const Air<S>& air, const S& s, const S& c, const S* p) {
    const PlanarForces<S> flow = flow_forces(plate.flow, {u.vx, u.vy, u.w - p[kSpin]});
    std::array<PlanarForce<S>, kTerms> terms;
    for (std::size_t k = 0; k < flow.size(); ++k) terms[k] = flow[k];
    terms[kInertia] = {plate.mass_y * u.w * u.vy, -plate.mass_x * u.w * u.vx,
                       (plate.mass_x - plate.mass_y) * u.vx * u.vy};
    terms[kWeight] = {-plate.weight * s, -plate.weight * c};
    const S area = S(std::numbers::pi) * p[FallingPlate::kSemiChord] * p[FallingPlate::kSemiThickness];
    const S mass = p[FallingPlate::kDensity] * area;
    const S displaced = p[FallingPlate::kFluidDensity] * area;
    const Along<S> material = {air.rate.x - air.xx * u.vx - air.xy * u.vy,
                               air.rate.y - air.yx * u.vx - air.yy * u.vy};
    const Along<S> impulse = {(plate.mass_x - mass) * u.vx, (plate.mass_y - mass) * u.vy};
    terms[kPlanarTerms] = {
        displaced * material.x - mass * air.rate.x - air.xx * impulse.x - air.yx * impulse.y,
        displaced * material.y - mass * air.rate.y - air.xy * impulse.x - air.yy * impulse.y};
    return terms;
  }

  template <class S>
  static PlanarMotion<S> relative(const Air<S>& air, const S* x) {
    return {x[kVx] - air.velocity.x, x[kVy] - air.velocity.y, x[kOmega]};
  }

  template <class S>
  static void rhs(const S& t, const S* x, const S* p, S* dxdt) {
    const auto [s, c] = sine_and_cosine(x[kTheta]);
    const EllipticPlate<S> plate = FallingPlate::plate(p);
    const Air<S> air(t, s, c, p);
    const PlanarForce<S> sum = total(terms_of(plate, relative(air, x), air, s, c, p));
    const S& w = x[kOmega];
    dxdt[kVx] = sum.x / plate.mass_x + air.rate.x + w * air.velocity.y;
    dxdt[kVy] = sum.y / plate.mass_y + air.rate.y - w * air.velocity.x;
    dxdt[kOmega] = sum.torque / plate.inertia;
    dxdt[kTheta] = w;
    dxdt[kX] = x[kVx] * c - x[kVy] * s;
    dxdt[kY] = x[kVx] * s + x[kVy] * c;
  }

  template <class S>
  static void forces(const S& t, const S* x, const S* p, LawWrench<S>* terms) {
    const auto [s, c] = sine_and_cosine(x[kTheta]);
    const Air<S> air(t, s, c, p);
    const PlanarMotion<S> u = relative(air, x);
    to_wrenches(terms_of(FallingPlate::plate(p), u, air, s, c, p), u, terms);
  }

  template <class S>
  static S kinetic_energy(const S& t, const S* x, const S* p) {
    const auto [s, c] = sine_and_cosine(x[kTheta]);
    const Air<S> air(t, s, c, p);
    const PlanarMotion<S> u = relative(air, x);
    const S motion[] = {u.vx, u.vy, u.w};
    return FallingPlate::plate(p).kinetic_energy(motion);
  }

  template <class S>
  static void complete(const char* given, S* p) {
    FallingPlate::complete(given, p);
  }

  static Scales scales(const double* p) { return FallingPlate::scales(p); }
};

}  // namespace

std::shared_ptr<const Model> falling_plate() {
  return std::make_shared<LawModel<FallingPlate>>();
}

std::shared_ptr<const Model> falling_plate_in_gusts() {
  return std::make_shared<LawModel<FallingPlateInGusts>>();
}

}  // namespace samara::models::laws
