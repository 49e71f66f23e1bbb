#include "samara/models/laws/immersed_body.h"
#include "samara/models/wakes/wake.h"

namespace samara::models::laws {

namespace {

/// immersed_body in still fluid with the wake and the separation of wake.h. Circulations over the chord are vectors in
/// the plane of the plate, q = -(C_T u_z/U) n x u and -C_R (b w_x, a w_y, 0): the lift is rho A u x q. What the wake
/// holds does not turn with the body about its normal, so that the spin of a round disc changes nothing.
struct ImmersedBodyWithWake {
  static constexpr int kGT = kPoseStates, kGR = kGT + 2, kStates = kGR + 2;
  enum Parameter {
    kWake = ImmersedBody::kParameters,
    kParameters = kWake + static_cast<int>(kWakeParameters)
  };
  enum Term { kInertial, kDrag, kTranslationalLift, kRotationalLift, kDamping, kGravity, kTerms };

  static ModelInfo info() {
    ModelInfo info = ImmersedBody::info();
    info.name = "immersed_body_with_wake";
    info.title = "Body in a fluid at rest, with a wake that remembers and flow that separates";
    info.equations =
        "(m + M) u' = ((m + M) u) x w + F;  "
        "(I + J) w' = ((I + J) w) x w + kappa (M u) x u + T;  "
        "(x, y, z)' = R u;  "
        "q' = 1/2 q (0, w);  "
        "G_Tx' = W/(2 b lag_T) (k_x - G_Tx) + w_z G_Ty;  "
        "G_Ty' = W/(2 a lag_T) (k_y - G_Ty) - w_z G_Tx;  "
        "G_Rx' = W/(2 b lag_R) (j_x - G_Rx) + w_z G_Ry;  "
        "G_Ry' = W/(2 a lag_R) (j_y - G_Ry) - w_z G_Rx;  "
        "F = N + (m - m_f) R^T (0, 0, -g);  "
        "T = p x (0, 0, N_z) + damping - m_f r_b x R^T (0, 0, -g);  "
        "N = drag + lift;  "
        "drag = -1/2 rho A (1 + Re_drag/Re) (C_D0 (v_x^2 + v_y^2) + (C_D90 + f C_DA) v_z^2)/U v;  "
        "lift = rho A v x ((1 - memory_T) k + memory_T (G_Tx, G_Ty, 0) + (1 - memory_R) j + memory_R (G_Rx, "
        "G_Ry, 0));  "
        "k = -(C_T + f C_TA)/(1 + Re_lift/Re) v_z/U n x v;  "
        "j = -1/2 C_R/(1 + Re_lift/Re) (l_x w_x, l_y w_y, 0);  "
        "damping = -(4/15 rho C_w a b^3 s_x w_x, 4/15 rho C_w b a^3 s_y w_y, 0) - (linear_damping_x w_x, "
        "linear_damping_y w_y, linear_damping_z w_z);  "
        "v = u + (w_x, w_y, 0) x p;  "
        "U = sqrt(|v|^2 + speed_floor^2);  "
        "Re = 2 a U/nu;  "
        "(l_x, l_y) = (1 - velocity_chord) (2 b, 2 a) + velocity_chord (l, l);  "
        "l = 2 a b sqrt(v_x^2 + v_y^2 + speed_floor^2)/h(v);  "
        "h(v) = sqrt(b^2 v_x^2 + a^2 v_y^2 + a b speed_floor^2);  "
        "p = (centre_of_pressure (1 - sin_alpha^3)/4 + (f (cp_attached - cp_slope sin_alpha^2) + (1 - f) "
        "cp_separated) "
        "sqrt(u_x^2 + u_y^2 + speed_floor^2)/W) (2 a b) (u_x, u_y, 0)/h(u);  "
        "f = 1/(1 + (sin_alpha/sin(stall_angle))^4);  "
        "sin_alpha = |u_z|/W;  "
        "W = sqrt(|u|^2 + speed_floor^2);  "
        "s_x = i s + (1 - i) b sqrt(w_x^2 + rate_floor^2);  "
        "s_y = i s + (1 - i) a sqrt(w_y^2 + rate_floor^2);  "
        "s = sqrt(b^2 w_x^2 + a^2 w_y^2 + a b rate_floor^2);  "
        "i = damping_isotropy;  "
        "A = pi a b;  "
        "n = (0, 0, 1);  "
        "rho = fluid_density;  "
        "m = mass;  "
        "m_f = displaced_mass";
    info.source +=
        "; H. Wagner, Z. angew. Math. Mech. 5 (1925) 17-35, with one exponential for his function; H. Li, T. "
        "Goodwill, "
        "Z. J. Wang, L. Ristroph, J. Fluid Mech. 937 (2022) A6, for the separation and the centre of "
        "pressure";
    info.validity =
        "flat bodies at Reynolds numbers of about 1e2 to 1e5 in still, unbounded fluid. The wake is known by "
        "its "
        "circulation alone: no vortex that a body meets again, no induced drag, no lag of the separation. "
        "Wagner's "
        "function is that of attached flow in the plane at a constant speed. Munk's moment holds the quarter "
        "chord of "
        "attached flow: beside a centre of pressure lower kappa, which below 1 may give power";
    info.symmetries = upright_symmetries();
    for (const auto& [name, what] : {std::pair{"G_Tx", "translational"},
                                     {"G_Ty", "translational"},
                                     {"G_Rx", "rotational"},
                                     {"G_Ry", "rotational"}}) {
      info.states.push_back(
          {.name = name,
           .unit = "m/s",
           .description = std::string(what) +
                          " circulation that the wake lets be, over the chord, about body " + name[3]});
    }
    append(info.parameters, wake_parameters());
    info.affine_in.insert(info.affine_in.end(), {"C_TA", "C_DA"});
    info.force_terms.pop_back();  // the fluid does not accelerate
    for (const Term lift : {kTranslationalLift, kRotationalLift})
      info.force_terms[lift].description += "; no power";
    for (const Term loss : {kDrag, kDamping}) info.force_terms[loss].description += "; takes power";
    return info;
  }

  template <class S>
  struct Flow {
    QuasiSteadyBody<S> body;
    S speed;          ///< of the centre [m/s]
    Vector3<S> p;     ///< the centre of pressure [m]
    Vector3<S> v;     ///< its velocity, without the spin of the body
    Vector3<S> k, j;  ///< quasi-steady circulations over the chord, translational and rotational [m/s]

    Flow(const Pose<S>& pose, const S* all) : body(ImmersedBody::quasi_steady(all)) {
      using std::sin;
      using std::sqrt;
      const S* const wake = all + kWake;
      const Vector3<S>& u = pose.u;
      speed = smooth_norm(u, body.speed_floor);
      const S sine_2 = u.z * u.z / (speed * speed);
      const S stall = sin(wake[kStallAngle]);
      const S attached = attached_share(sine_2, stall * stall);
      const S offset = pressure_offset(wake + kCp, attached, sine_2) *
                       chord_along(body.a, body.b, u, body.speed_floor) / speed;
      p = centre_of_pressure(body, u) + offset * Vector3<S>{u.x, u.y, S(0.0)};
      v = {u.x, u.y, u.z + pose.w.x * p.y - pose.w.y * p.x};
      body.C_T = body.C_T + attached * wake[kCTA];
      body.C_D90 = body.C_D90 + attached * wake[kCDA];
      body.centre_of_pressure = S(0.0);  // forces are asked for at p itself
      const S U = smooth_norm(v, body.speed_floor);
      const S of_lift = U / (U + body.Re.lift);
      const S translational = -of_lift * body.C_T * v.z / U;
      k = {-translational * v.y, translational * v.x, S(0.0)};
      j = S(-0.5) * of_lift * body.C_R * rates_of_chords(body, v, pose.w);
    }

    /// A force at the centre of pressure: its part along the normal turns the body.
    Load<S> at_pressure(const Vector3<S>& force) const {
      return {force, {p.y * force.z, -p.x * force.z, S(0.0)}};
    }

    /// The lift of a share of a circulation that is remembered in place of the quasi-steady one.
    Vector3<S> lift(const Vector3<S>& quasi_steady, const S* remembered, const S& memory) const {
      const S rho_A = S(std::numbers::pi) * body.fluid_density * body.a * body.b;
      const Vector3<S> held = {remembered[0], remembered[1], S(0.0)};
      return rho_A * cross(v, (S(1.0) - memory) * quasi_steady + memory * held);
    }

    /// Rates of a circulation that is remembered.
    void remember(const Vector3<S>& quasi_steady, const S* held, const S& w_z, const S& lag, S* rate) const {
      const S half = S(0.5) * speed / lag;
      rate[0] = half / body.b * (quasi_steady.x - held[0]) + w_z * held[1];
      rate[1] = half / body.a * (quasi_steady.y - held[1]) - w_z * held[0];
    }
  };

  template <class S>
  static std::array<Load<S>, kTerms> loads(const Pose<S>& pose, const Flow<S>& flow, const S* x, const S* p) {
    const S* const wake = p + kWake;
    const QuasiSteadyLoads<S> at_once = quasi_steady_loads(flow.body, flow.v, pose.w);
    std::array<Load<S>, kTerms> all;
    all[kInertial] = EllipsoidBody::inertial_load(pose.u, pose.w, p[ImmersedBody::kKappa], p);
    all[kDrag] = flow.at_pressure(at_once.drag.force);
    all[kTranslationalLift] = flow.at_pressure(flow.lift(flow.k, x + kGT, wake[kMemoryT]));
    all[kRotationalLift] = flow.at_pressure(flow.lift(flow.j, x + kGR, wake[kMemoryR]));
    all[kDamping] = at_once.damping;
    all[kGravity] = gravity_and_buoyancy(pose.R, p[EllipsoidBody::kMass], p[EllipsoidBody::kDisplacedMass],
                                         vector3(p + EllipsoidBody::kBuoyancyCentre), p[EllipsoidBody::kG]);
    return all;
  }

  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    const Pose<S> pose(x);
    const Flow<S> flow(pose, p);
    Load<S> sum;
    for (const Load<S>& load : loads(pose, flow, x, p)) sum = sum + load;
    pose_rates(pose, x, dxdt);
    store(diagonal_solve(EllipsoidBody::total_mass(p), sum.force), dxdt + kUx);
    store(diagonal_solve(EllipsoidBody::total_inertia(p), sum.torque), dxdt + kWx);
    flow.remember(flow.k, x + kGT, pose.w.z, p[kWake + int{kLagT}], dxdt + kGT);
    flow.remember(flow.j, x + kGR, pose.w.z, p[kWake + int{kLagR}], dxdt + kGR);
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    const Pose<S> pose(x);
    for (const Load<S>& load : loads(pose, Flow<S>(pose, p), x, p)) *terms++ = wrench(load, pose.u, pose.w);
  }

  /// 1/2 (u . P + w . L)
  template <class S>
  static S kinetic_energy(const S&, const S* x, const S* p) {
    const Pose<S> pose(x);
    return S(0.5) * (dot(pose.u, diagonal_times(EllipsoidBody::total_mass(p), pose.u)) +
                     dot(pose.w, diagonal_times(EllipsoidBody::total_inertia(p), pose.w)));
  }

  template <class S>
  static void complete(const char* given, S* p) {
    ImmersedBody::complete(given, p);
  }

  static Scales scales(const double* p) { return ImmersedBody::scales(p); }
};

}  // namespace

std::shared_ptr<const Model> immersed_body_with_wake() {
  return std::make_shared<LawModel<ImmersedBodyWithWake>>();
}

}  // namespace samara::models::laws
