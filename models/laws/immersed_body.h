#pragma once

#include <array>

#include "samara/models/laws/ambient_policies.h"
#include "samara/models/laws/ellipsoid_body.h"
#include "samara/models/laws/quasi_steady_forces.h"

/// The three-dimensional quasi-steady body, for any ambient flow.
///
/// With the velocity relative to the fluid u_r = u - R^T w_air, the momentum relative to it P_r = (m + M) u_r
/// and L = (I + J) w (M, J the added mass and inertia, diagonal in body axes),
///
///   dP_r/dt = P_r x w                      + F + m_f R^T Dw_air/Dt - m R^T (dw_air/dt + (v . grad) w_air)
///                                              - R^T (grad w_air)^T R M u_r
///   dL/dt   = L x w + kappa (M u_r) x u_r  + T + m_f r_b x R^T Dw_air/Dt
///
/// which is Kirchhoff's equation for P = m u + M u_r, so that a steady uniform wind only carries the motion
/// along. F and T: quasi_steady_forces.h, gravity and buoyancy. The last force: gradient_force().
namespace samara::models::laws {

struct ImmersedBody : EllipsoidBody {
  enum Parameter {
    kCD0 = kBodyParameters,
    kCD90,
    kCT,
    kCR,
    kCw,
    kDampingIsotropy,
    kLinearDamping,
    kCentreOfPressure = kLinearDamping + 3,
    kKappa,
    kVelocityChord,
    kSpeedFloor,
    kRateFloor,
    kReDrag,
    kReLift,
    kNu,
    kParameters
  };
  enum Term { kInertial, kDrag, kTranslationalLift, kRotationalLift, kDamping, kGravity, kAmbient, kTerms };

  /// Without name, title, parameters and symmetries of the ambient flow.
  static ModelInfo info();

  template <class S>
  static QuasiSteadyBody<S> quasi_steady(const S* p) {
    return {.a = p[kA],
            .b = p[kB],
            .fluid_density = p[kFluidDensity],
            .C_D0 = p[kCD0],
            .C_D90 = p[kCD90],
            .C_T = p[kCT],
            .C_R = p[kCR],
            .C_w = p[kCw],
            .isotropy = p[kDampingIsotropy],
            .linear_damping = vector3(p + kLinearDamping),
            .speed_floor = p[kSpeedFloor],
            .rate_floor = p[kRateFloor],
            .centre_of_pressure = p[kCentreOfPressure],
            .velocity_chord = p[kVelocityChord],
            .Re = reynolds_speeds(p[kReDrag], p[kReLift], p[kNu], S(2.0) * p[kA])};
  }

  template <class Flow, class S>
  static std::array<Load<S>, kTerms> loads(const Pose<S>& pose, const Vector3<S>& u_r, const Vector3<S>& w_r,
                                           const Ambient<S>& ambient, const S* p) {
    const QuasiSteadyLoads<S> flow = quasi_steady_loads(quasi_steady(p), u_r, w_r);
    std::array<Load<S>, kTerms> all;
    all[kInertial] = inertial_load(u_r, pose.w, p[kKappa], p);
    all[kDrag] = flow.drag;
    all[kTranslationalLift] = flow.translational_lift;
    all[kRotationalLift] = flow.rotational_lift;
    all[kDamping] = flow.damping;
    all[kGravity] =
        gravity_and_buoyancy(pose.R, p[kMass], p[kDisplacedMass], vector3(p + kBuoyancyCentre), p[kG]);
    const Vector3<S> pressure =
        p[kDisplacedMass] * pose.R.to_body(ambient.material_rate);  // at r_b, as buoyancy
    const Vector3<S> impulse = diagonal_times(vector3(p + kAddedMass), u_r);
    all[kAmbient] = {pressure - p[kMass] * pose.R.to_body(ambient.path_rate) +
                         gradient_force<Flow>(pose.R, impulse, ambient),
                     cross(vector3(p + kBuoyancyCentre), pressure)};
    return all;
  }

  template <class S, class Flow>
  static Ambient<S> ambient(const Flow& flow, const Pose<S>& pose, const S& t, const S* x, const S* p) {
    return flow.at(t, vector3(x + kPosition), pose.R.to_world(pose.u), p + kParameters);
  }

  /// u_r' = (m + M)^-1 (sum of forces), and u' = u_r' + d(R^T w_air)/dt.
  template <class S, class Flow>
  static void rhs(const Flow& flow, const S& t, const S* x, const S* p, S* dxdt) {
    const Pose<S> pose(x);
    const Ambient<S> air = ambient(flow, pose, t, x, p);
    const Vector3<S> w_air = pose.R.to_body(air.velocity);
    const Vector3<S> w_r = relative_rate<Flow>(pose.R, pose.w, air);
    Load<S> sum;
    for (const Load<S>& load : loads<Flow>(pose, pose.u - w_air, w_r, air, p)) sum = sum + load;
    pose_rates(pose, x, dxdt);
    const Vector3<S> u_r_rate = diagonal_solve(total_mass(p), sum.force);
    store(u_r_rate + pose.R.to_body(air.path_rate) + cross(w_air, pose.w), dxdt + kUx);
    store(diagonal_solve(total_inertia(p), sum.torque), dxdt + kWx);
  }

  template <class S, class Flow>
  static void forces(const Flow& flow, const S& t, const S* x, const S* p, LawWrench<S>* terms) {
    const Pose<S> pose(x);
    const Ambient<S> air = ambient(flow, pose, t, x, p);
    const Vector3<S> u_r = pose.u - pose.R.to_body(air.velocity);
    const Vector3<S> w_r = relative_rate<Flow>(pose.R, pose.w, air);
    const std::array<Load<S>, kTerms> all = loads<Flow>(pose, u_r, w_r, air, p);
    for (std::size_t k = 0; k < all.size(); ++k) terms[k] = wrench(all[k], u_r, pose.w);
  }

  /// 1/2 (u_r . P_r + w . L)
  template <class S, class Flow>
  static S kinetic_energy(const Flow& flow, const S& t, const S* x, const S* p) {
    const Pose<S> pose(x);
    const Vector3<S> u_r = pose.u - pose.R.to_body(ambient(flow, pose, t, x, p).velocity);
    return S(0.5) * (dot(u_r, diagonal_times(total_mass(p), u_r)) +
                     dot(pose.w, diagonal_times(total_inertia(p), pose.w)));
  }

  static Scales scales(const double* p);
};

/// The body in an ambient flow, as a law: a static policy of ambient_policies.h, or one that carries a field.
template <class Flow>
struct ImmersedBodyIn {
  static constexpr int kStates = kPoseStates;
  static constexpr int kParameters = ImmersedBody::kParameters + Flow::kParameters;

  Flow flow = {};

  ModelInfo info() const;

  template <class S>
  void rhs(const S& t, const S* x, const S* p, S* dxdt) const {
    ImmersedBody::rhs(flow, t, x, p, dxdt);
  }
  template <class S>
  void forces(const S& t, const S* x, const S* p, LawWrench<S>* terms) const {
    ImmersedBody::forces(flow, t, x, p, terms);
  }
  template <class S>
  S kinetic_energy(const S& t, const S* x, const S* p) const {
    return ImmersedBody::kinetic_energy(flow, t, x, p);
  }
  template <class S>
  static void complete(const char* given, S* p) {
    ImmersedBody::complete(given, p);
  }
  static Scales scales(const double* p) { return ImmersedBody::scales(p); }
};

template <>
ModelInfo ImmersedBodyIn<StillFluid>::info() const;
template <>
ModelInfo ImmersedBodyIn<LinearWind>::info() const;
template <>
ModelInfo ImmersedBodyIn<GustRamp>::info() const;

}  // namespace samara::models::laws
