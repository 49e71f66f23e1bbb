#include "immersed_body_printed.h"

#include <algorithm>
#include <array>

#include "samara/models/law_tools/parameter_list.h"
#include "samara/models/laws/ellipsoid_body.h"

namespace samara::models::laws {

namespace {

struct ImmersedBodyPrinted : EllipsoidBody {
  static constexpr int kStates = kPoseStates;
  enum Parameter {
    kCD = kBodyParameters,
    kCL1,
    kCL2,
    kCentreOfPressure,
    kSpeedFloor,
    kRateFloor,
    kParameters
  };
  enum Term { kInertial, kDrag, kFirstLift, kSecondLift, kGravity, kTerms };

  static ModelInfo info() {
    return {
        .name = "immersed_body_printed",
        .title = "Body with the forces of dissertation chapter 5 as printed, for comparison only",
        .equations =
            "dP/dt = P x w + F + (m - m_f) R^T (0, 0, -g);  "
            "dL/dt = L x w + P x u + p x F + m_f r_b x R^T (0, 0, -g);  "
            "P = (m + M) u;  "
            "L = (I + J) w;  "
            "(x, y, z)' = R u;  "
            "q' = 1/2 q (0, w);  "
            "F = 1/2 rho A (-C_D u_z^2 e1 + 2 C_L1 |u_z| u_t e2 + C_L2 (u_x^2 + u_y^2 - u_z^2) e3);  "
            "e1 = u/sqrt(|u|^2 + speed_floor^2);  "
            "e2 = (w x u)/sqrt(|w x u|^2 + speed_floor^2 rate_floor^2);  "
            "e3 = e2 x e1;  "
            "p = centre_of_pressure (1 - sin_alpha^3) a/4 (u_x, u_y, 0)/u_t;  "
            "u_t = sqrt(u_x^2 + u_y^2 + speed_floor^2);  "
            "sin_alpha = |u_z|/sqrt(|u|^2 + speed_floor^2);  "
            "A = pi a b;  "
            "rho = fluid_density;  "
            "m = mass;  "
            "m_f = displaced_mass",
        .frames =
            "world: z up; body: origin at the centre of mass, axes the principal ones, z the normal of the "
            "plate. x, y, z in the world; q turns body into world; u and w along body axes",
        .source =
            "dissertation (5.12)-(5.19), frame vectors of (5.16) taken as unit vectors, the missing "
            "direction of p taken as that of the tangential velocity; the total inertia that (5.14) leaves "
            "out is put back",
        .validity =
            "for comparison with the source only: wrong as physics. The second lift points along the axis "
            "of rotation, so that planar motion leaves its plane; the directions jump where u or w x u "
            "vanish (here within the floors); force at p with the velocity of the centre creates energy; "
            "edge-on motion and rotation are undamped; the torque of buoyancy has the wrong sign. Use "
            "immersed_body",
        .symmetries = upright_symmetries(),
        .states = pose_states(),
        .parameters = parameters(),
        .affine_in = {"C_D", "C_L1", "C_L2"},
        .force_terms = {{.name = "inertia", .description = "P x w, and L x w + (M u) x u"},
                        {.name = "drag", .description = "C_D, along e1, at p"},
                        {.name = "first lift", .description = "C_L1, along e2, at p"},
                        {.name = "second lift", .description = "C_L2, along e3, at p"},
                        {.name = "gravity and buoyancy", .description = "torque with the printed sign"}},
        .groups = pose_groups(),
    };
  }

  static Parameters parameters() {
    Parameters list = EllipsoidBody::parameters();
    append(list,
           {any_value("C_D", "1", 0.61,
                      "drag coefficient broadside; default: first set of Figure 5.6 that tumbles"),
            any_value("C_L1", "1", 1.81, "coefficient of the first lift"),
            any_value("C_L2", "1", 1.21, "coefficient of the second lift"),
            any_value("centre_of_pressure", "1", 1.0,
                      "factor of the offset of the centre of pressure, either sign"),
            with_default(positive("speed_floor", "m/s", "speed below which directions fade to zero"), 1e-3),
            with_default(positive("rate_floor", "rad/s", "rate below which e2 and e3 fade to zero"), 1e-3)});
    return list;
  }

  /// The frame (5.16) as unit vectors that fade to zero smoothly where they are undefined.
  template <class S>
  struct Frame {
    Vector3<S> e1, e2, e3;

    Frame(const Vector3<S>& u, const Vector3<S>& w, const S& speed_floor, const S& rate_floor) {
      using std::sqrt;
      const Vector3<S> across = cross(w, u);
      const S floor = speed_floor * rate_floor;
      e1 = (S(1.0) / sqrt(dot(u, u) + speed_floor * speed_floor)) * u;
      e2 = (S(1.0) / sqrt(dot(across, across) + floor * floor)) * across;
      e3 = cross(e2, e1);
    }
  };

  template <class S>
  static std::array<Load<S>, kTerms> loads(const Pose<S>& pose, const S* p) {
    using std::abs;
    using std::sqrt;
    const Vector3<S>& u = pose.u;
    const Frame<S> frame(u, pose.w, p[kSpeedFloor], p[kRateFloor]);
    const S floor_2 = p[kSpeedFloor] * p[kSpeedFloor];
    const S tangential_2 = u.x * u.x + u.y * u.y;
    const S speed_2 = dot(u, u) + floor_2;
    const S normal = abs(u.z);
    const S tangential = sqrt(tangential_2 + floor_2);
    const S sin_alpha = normal / sqrt(speed_2);
    // |u|^2 times sin^2 alpha, sin 2 alpha and cos 2 alpha.
    const S half_rho_A = S(0.5 * std::numbers::pi) * p[kFluidDensity] * p[kA] * p[kB];
    const Vector3<S> drag = -(half_rho_A * p[kCD] * u.z * u.z) * frame.e1;
    const Vector3<S> first =
        (half_rho_A * p[kCL1] * S(2.0) * normal * sqrt(tangential_2 + floor_2)) * frame.e2;
    const Vector3<S> second = (half_rho_A * p[kCL2] * (tangential_2 - u.z * u.z)) * frame.e3;
    const S arm =
        p[kCentreOfPressure] * (S(1.0) - sin_alpha * sin_alpha * sin_alpha) * p[kA] / (S(4.0) * tangential);
    const Vector3<S> centre = {arm * u.x, arm * u.y, S(0.0)};
    // Minus the right torque of buoyancy is the printed one.
    const Vector3<S> printed_r_b = S(-1.0) * vector3(p + kBuoyancyCentre);
    return {inertial_load(u, pose.w, S(1.0), p), force_at(centre, drag), force_at(centre, first),
            force_at(centre, second),
            gravity_and_buoyancy(pose.R, p[kMass], p[kDisplacedMass], printed_r_b, p[kG])};
  }

  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    const Pose<S> pose(x);
    Load<S> sum;
    for (const Load<S>& load : loads(pose, p)) sum = sum + load;
    pose_rates(pose, x, dxdt);
    store(diagonal_solve(total_mass(p), sum.force), dxdt + kUx);
    store(diagonal_solve(total_inertia(p), sum.torque), dxdt + kWx);
  }

  template <class S>
  static void forces(const S&, const S* x, const S* p, LawWrench<S>* terms) {
    const Pose<S> pose(x);
    const std::array<Load<S>, kTerms> all = loads(pose, p);
    for (std::size_t k = 0; k < all.size(); ++k) terms[k] = wrench(all[k], pose.u, pose.w);
  }

  template <class S>
  static S kinetic_energy(const S&, const S* x, const S* p) {
    const Pose<S> pose(x);
    return S(0.5) * (dot(pose.u, diagonal_times(total_mass(p), pose.u)) +
                     dot(pose.w, diagonal_times(total_inertia(p), pose.w)));
  }

  static Scales scales(const double* p) {
    const double k = 0.5 * p[kFluidDensity] * std::numbers::pi * p[kA] * p[kB] *
                     std::max(kLeastDragCoefficient, std::abs(p[kCD]));
    return body_scales(2.0 * std::max(p[kA], p[kB]), (p[kMass] - p[kDisplacedMass]) * p[kG], p[kMass], k);
  }
};

}  // namespace

}  // namespace samara::models::laws

std::shared_ptr<const samara::models::Model> immersed_body_printed() {
  return std::make_shared<samara::models::LawModel<samara::models::laws::ImmersedBodyPrinted>>();
}
