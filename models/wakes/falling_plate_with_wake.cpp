#include "samara/models/laws/falling_plate.h"
#include "samara/models/wakes/wake.h"

namespace samara::models::laws {

namespace {

/// falling_plate with the wake and the separation of wake.h.
struct FallingPlateWithWake {
  static constexpr int kGT = kPlanarStates, kGR = kGT + 1, kStates = kGR + 1;
  enum Parameter {
    kWake = FallingPlate::kParameters,
    kKappa = kWake + static_cast<int>(kWakeParameters),
    kParameters,
  };

  static ModelInfo info() {
    ModelInfo info = FallingPlate::info();
    info.name = "falling_plate_with_wake";
    info.title = "Falling elliptic plate in its plane, with a wake that remembers and flow that separates";
    info.equations =
        "(m + m11) vx' = (m + m22) w vy - fluid_density G vp - (m - m_f) g sin(theta) - Fx,  "
        "(m + m22) vy' = -(m + m11) w vx + fluid_density G vx - (m - m_f) g cos(theta) - Fy,  "
        "(I + I_a) w' = kappa (m11 - m22) vx vy + p (fluid_density G vx - Fy) - pi fluid_density a^4 (mu1 "
        "U/a + "
        "mu2 |w|) w,  theta' = w,  "
        "x' = vx cos(theta) - vy sin(theta),  y' = vx sin(theta) + vy cos(theta),  "
        "G_T' = V/(2 a lag_T) (q_T - G_T),  G_R' = V/(2 a lag_R) (q_R - G_R),  "
        "G = 2 a ((1 - memory_T) q_T + memory_T G_T + (1 - memory_R) q_R + memory_R G_R),  "
        "q_T = -(C_T + f C_TA) vx vp/v/(1 + Re_lift/Re),  q_R = C_R a w/(1 + Re_lift/Re),  "
        "(Fx, Fy) = fluid_density a (1 + Re_drag/Re) (A - B (vx^2 - vp^2)/v^2 + f C_DA vp^2/v^2) v (vx, vp), "
        " "
        "vp = vy + p w,  v = sqrt(vx^2 + vp^2 + speed_floor^2),  Re = 2 a v/nu,  "
        "p = 2 a (f (cp_attached - cp_slope vy^2/V^2) + (1 - f) cp_separated) vx/V,  "
        "f = 1/(1 + (vy/V/sin(stall_angle))^4),  V = sqrt(vx^2 + vy^2 + speed_floor^2),  "
        "U = sqrt(|density/fluid_density - 1| g b),  m = pi density a b,  "
        "m_f = pi fluid_density a b,  I = m (a^2 + b^2)/4,  m11 = pi fluid_density b^2,  "
        "m22 = pi fluid_density a^2,  I_a = pi/8 fluid_density (a^2 - b^2)^2,  a = semi_chord,  "
        "b = semi_thickness";
    info.source +=
        "; H. Wagner, Z. angew. Math. Mech. 5 (1925) 17-35, with one exponential for his function; H. Li, T. "
        "Goodwill, "
        "Z. J. Wang, L. Ristroph, J. Fluid Mech. 937 (2022) A6, for the separation and the centre of "
        "pressure";
    info.validity =
        "motion in a plane, thin plates, Reynolds numbers of about 1e2 to 1e4; still, unbounded fluid. The "
        "wake is known "
        "by its circulation alone: no vortex that a plate meets again, no induced drag, no lag of the "
        "separation. Wagner's "
        "function is that of attached flow at a constant speed. Munk's moment holds the quarter chord of "
        "attached flow: "
        "beside a centre of pressure lower kappa, which below 1 may give power. In U, |q| is taken as "
        "sqrt(q^2 + 1e-24)";
    info.symmetries = {"translation of x", "translation of y", "turn of the body by pi",
                       "reflection: vx, w, theta, x, G_T and G_R change sign"};
    info.states.push_back({.name = "G_T",
                           .unit = "m/s",
                           .description = "translational circulation that the wake lets be, over the chord"});
    info.states.push_back({.name = "G_R",
                           .unit = "m/s",
                           .description = "rotational circulation that the wake lets be, over the chord"});
    append(info.parameters, wake_parameters());
    info.parameters.push_back(share("kappa", 1.0, "factor of Munk's moment (m11 - m22) vx vy"));
    info.affine_in.insert(info.affine_in.end(), {"C_TA", "C_DA"});
    return info;
  }

  /// Over the chord [m/s].
  template <class S>
  struct Circulation {
    S quasi_steady, remembered, memory;

    S bound() const { return quasi_steady + memory * (remembered - quasi_steady); }
  };

  template <class S>
  struct Flow {
    EllipticPlate<S> plate;
    S chord;
    S speed;   ///< of the centre
    S offset;  ///< of the centre of pressure, along x' [m]
    PlanarMotion<S> at_pressure;
    S attached;
    Circulation<S> T, R;

    Flow(const S* x, const S* p)
        : plate(FallingPlate::plate(p)), chord(S(2.0) * p[FallingPlate::kSemiChord]) {
      using std::sin;
      using std::sqrt;
      const S* const wake = p + kWake;
      const S floor2 = plate.flow.speed_floor * plate.flow.speed_floor;
      const S speed2 = x[kVx] * x[kVx] + x[kVy] * x[kVy] + floor2;
      speed = sqrt(speed2);
      const S sine_2 = x[kVy] * x[kVy] / speed2;
      const S stall = sin(wake[kStallAngle]);
      attached = attached_share(sine_2, stall * stall);
      offset = chord * pressure_offset(wake + kCp, attached, sine_2) * x[kVx] / speed;
      const S& w = x[kOmega];
      at_pressure = {x[kVx], x[kVy] + offset * w, w};
      const S& vp = at_pressure.vy;
      const S v = sqrt(x[kVx] * x[kVx] + vp * vp + floor2);
      const S over_v = S(1.0) / (v + plate.flow.Re.lift);
      const S C_T = p[FallingPlate::kCT] + attached * wake[kCTA];
      T = {-C_T * x[kVx] * vp * over_v, x[kGT], wake[kMemoryT]};
      R = {S(0.5) * chord * p[FallingPlate::kCR] * w * v * over_v, x[kGR], wake[kMemoryR]};
      plate.flow.drag_normal = plate.flow.drag_normal + S(0.5) * density(p) * chord * attached * wake[kCDA];
    }

    static const S& density(const S* p) { return p[FallingPlate::kFluidDensity]; }

    PlanarForces<S> forces(const S* x, const Heading<S>& heading, const S* p) const {
      PlanarForces<S> terms = flow_forces(plate.flow, at_pressure);
      const S& w = x[kOmega];
      const S lift = density(p) * chord;
      const S lift_T = lift * T.bound();
      const S lift_R = lift * R.bound();
      terms[kTranslationalLift] = {-lift_T * at_pressure.vy, lift_T * at_pressure.vx};
      terms[kRotationalLift] = {-lift_R * at_pressure.vy, lift_R * at_pressure.vx};
      for (const PlanarTerm moved : {kTranslationalLift, kRotationalLift, kDrag})
        terms[moved].torque = offset * terms[moved].y;
      terms[kInertia] = {plate.mass_y * w * x[kVy], -plate.mass_x * w * x[kVx],
                         p[kKappa] * (plate.mass_x - plate.mass_y) * x[kVx] * x[kVy]};
      terms[kWeight] = {-plate.weight * heading.sine, -plate.weight * heading.cosine};
      return terms;
    }
  };

  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    const Flow<S> flow(x, p);
    const Heading<S> heading(x);
    const PlanarForce<S> sum = total(flow.forces(x, heading, p));
    dxdt[kVx] = sum.x / flow.plate.mass_x;
    dxdt[kVy] = sum.y / flow.plate.mass_y;
    dxdt[kOmega] = sum.torque / flow.plate.inertia;
    planar_kinematics(x, heading, dxdt);
    const S* const wake = p + kWake;
    const S chords = flow.speed / flow.chord;
    dxdt[kGT] = chords / wake[kLagT] * (flow.T.quasi_steady - x[kGT]);
    dxdt[kGR] = chords / wake[kLagR] * (flow.R.quasi_steady - x[kGR]);
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    to_wrenches(Flow<S>(x, p).forces(x, Heading<S>(x), p), {x[kVx], x[kVy], x[kOmega]}, terms);
  }

  template <class S>
  static S kinetic_energy(const S&, const S* x, const S* p) {
    return FallingPlate::plate(p).kinetic_energy(x);
  }

  template <class S>
  static void complete(const char* given, S* p) {
    FallingPlate::complete(given, p);
  }

  static Scales scales(const double* p) { return FallingPlate::scales(p); }
};

}  // namespace

std::shared_ptr<const Model> falling_plate_with_wake() {
  return std::make_shared<LawModel<FallingPlateWithWake>>();
}

}  // namespace samara::models::laws
