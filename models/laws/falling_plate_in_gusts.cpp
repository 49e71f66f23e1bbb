#include "samara/models/laws/falling_plate.h"

namespace samara::models::laws {

namespace {

/// The plate in a fluid that accelerates: the equations of falling_plate for the velocity relative to it, with the
/// pressure gradient and the inertia of that acceleration.
struct FallingPlateInGusts {
  static constexpr int kStates = kPlanarStates;
  enum Parameter {
    kStart = FallingPlate::kParameters,
    kGust,
    kRate = kGust + 2,
    kMaterial = kRate + 2,
    kSpin = kMaterial + 2,
    kParameters
  };
  static constexpr std::size_t kTerms =
      kPlanarTerms + 1;  ///< the last one is that of the fluid's acceleration

  static ModelInfo info() {
    ModelInfo info = FallingPlate::info();
    info.name = "falling_plate_in_gusts";
    info.title = "Falling elliptic plate in its plane, in a fluid that changes in time, per unit span";
    info.equations =
        "(m + m11) ux' = (m + m22) w uy - fluid_density G uy - (m - m_f) g sin(theta) - Fx + ax,  "
        "(m + m22) uy' = -(m + m11) w ux + fluid_density G ux - (m - m_f) g cos(theta) - Fy + ay,  "
        "(I + I_a) w' = (m11 - m22) ux uy - pi fluid_density a^4 (mu1 U/a + mu2 |w_r|) w_r,  "
        "(vx, vy)' = (ux, uy)' + d(R^T w_air)/dt,  "
        "(ux, uy) = (vx, vy) - R^T w_air,  w_r = w - gust_spin,  "
        "(ax, ay) = R^T (m_f (gust_material_x, gust_material_y) - m (gust_rate_x, gust_rate_y)),  "
        "w_air = (gust_x, gust_y) + (t - gust_start) (gust_rate_x, gust_rate_y),  "
        "R^T (X, Y) = (X cos(theta) + Y sin(theta), -X sin(theta) + Y cos(theta)),  "
        "theta' = w,  x' = vx cos(theta) - vy sin(theta),  y' = vx sin(theta) + vy cos(theta),  "
        "G, F, v, Re, U and the masses as for falling_plate, with ux, uy, w_r in place of vx, vy, w";
    info.validity +=
        ". The fluid is the same over the chord. Realisations (samara simulate --realisations) set the gust "
        "step by "
        "step; by itself it is one ramp in time";
    info.symmetries = {"translation of x", "translation of y", "turn of the body by pi"};
    append(info.parameters,
           {any_value("gust_start", "s", 0.0, "time at which the velocity is (gust_x, gust_y)"),
            any_value("gust_x", "m/s", 0.0, "velocity of the fluid at gust_start"),
            any_value("gust_y", "m/s", 0.0, "velocity of the fluid at gust_start, upward"),
            any_value("gust_rate_x", "m/s^2", 0.0, "its rate along the path of the plate"),
            any_value("gust_rate_y", "m/s^2", 0.0, "its rate along the path of the plate"),
            any_value("gust_material_x", "m/s^2", 0.0, "its rate along the path of the fluid"),
            any_value("gust_material_y", "m/s^2", 0.0, "its rate along the path of the fluid"),
            any_value("gust_spin", "rad/s", 0.0, "angular velocity of the fluid, in the sense of theta")});
    info.force_terms.push_back({.name = "ambient acceleration",
                                .description =
                                    "pressure gradient of the undisturbed fluid, less the mass times "
                                    "the rate of its velocity along the path; takes or gives power"});
    return info;
  }

  /// A vector along the chord and the normal.
  template <class S>
  struct Along {
    S x, y;
  };

  template <class S>
  struct Air {
    Along<S> velocity, rate, material;  ///< in body axes

    Air(const S& t, const S& s, const S& c, const S* p) {
      const auto turned = [&](const S& X, const S& Y) { return Along<S>{X * c + Y * s, Y * c - X * s}; };
      const S dt = t - p[kStart];
      velocity = turned(p[kGust] + dt * p[kRate], p[kGust + 1] + dt * p[kRate + 1]);
      rate = turned(p[kRate], p[kRate + 1]);
      material = turned(p[kMaterial], p[kMaterial + 1]);
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
    terms[kPlanarTerms] = {displaced * air.material.x - mass * air.rate.x,
                           displaced * air.material.y - mass * air.rate.y};
    return terms;
  }

  template <class S>
  static PlanarMotion<S> relative(const Air<S>& air, const S* x) {
    return {x[kVx] - air.velocity.x, x[kVy] - air.velocity.y, x[kOmega]};
  }

  template <class S>
  static void rhs(const S& t, const S* x, const S* p, S* dxdt) {
    using std::cos;
    using std::sin;
    const S s = sin(x[kTheta]);
    const S c = cos(x[kTheta]);
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
    using std::cos;
    using std::sin;
    const S s = sin(x[kTheta]);
    const S c = cos(x[kTheta]);
    const Air<S> air(t, s, c, p);
    const PlanarMotion<S> u = relative(air, x);
    to_wrenches(terms_of(FallingPlate::plate(p), u, air, s, c, p), u, terms);
  }

  template <class S>
  static S kinetic_energy(const S& t, const S* x, const S* p) {
    using std::cos;
    using std::sin;
    const Air<S> air(t, sin(x[kTheta]), cos(x[kTheta]), p);
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

std::shared_ptr<const Model> falling_plate_in_gusts() {
  return std::make_shared<LawModel<FallingPlateInGusts>>();
}

}  // namespace samara::models::laws
