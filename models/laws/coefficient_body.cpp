#include <algorithm>
#include <array>

#include "samara/models/batch/lane_sine.h"
#include "samara/models/law_tools/reynolds.h"
#include "samara/models/laws/spatial_body.h"

namespace samara::models::laws {

namespace {

/// The angles of flow and the axes they belong to: x along the velocity, y sideways, z below.
template <class S>
struct FlowAxes {
  S alpha, beta, speed_2;
  Vector3<S> x, y, z;  ///< in body components

  /// Angles smoothed below the speed `floor` [m/s], so that they and their derivatives are finite for every
  /// u, and zero at rest; for flow from the front they err by less than (floor/|u|)^2/2. The axes are unit
  /// vectors throughout. tan(alpha/2) = u_z / (v + u_x), v = sqrt(u_x^2 + u_z^2 + floor^2), has no quotient
  /// that vanishes.
  FlowAxes(const Vector3<S>& u, const S& floor) {
    using std::abs;
    using std::atan2;
    using std::sqrt;
    const S across_2 = u.z * u.z + floor * floor;
    const S in_plane = sqrt(u.x * u.x + across_2);
    const S forward = abs(u.x);
    const S beyond = u.x + forward + across_2 / (in_plane + forward);  // v + u_x, also for u_x near -v
    alpha = S(2.0) * atan2(u.z, beyond);
    beta = atan2(u.y, in_plane);
    speed_2 = dot(u, u);
    const auto [sin_alpha, cos_alpha] = sine_and_cosine(alpha);
    const auto [sin_beta, cos_beta] = sine_and_cosine(beta);
    x = {cos_alpha * cos_beta, sin_beta, sin_alpha * cos_beta};
    y = {-cos_alpha * sin_beta, cos_beta, -sin_alpha * sin_beta};
    z = {-sin_alpha, S(0.0), cos_alpha};
  }

  Vector3<S> to_body(const Vector3<S>& s) const { return s.x * x + s.y * y + s.z * z; }
};

struct CoefficientBody : SpatialBody<CoefficientBody> {
  static constexpr int kStates = kPoseStates;
  enum Parameter {
    kMass,
    kInertia,
    kMassCentre = kInertia + 3,
    kOffsetMass = kMassCentre + 3,
    kOffset,
    kDisplacedMass = kOffset + 3,
    kFluidDensity,
    kG,
    kArea,
    kAddedMass,
    kAddedInertia = kAddedMass + 3,
    kThrustLeft = kAddedInertia + 3,
    kThrustRight,
    kThrustArm,
    kCd,
    kCs = kCd + 3,
    kCl = kCs + 3,
    kCmx = kCl + 3,
    kCmy = kCmx + 3,
    kCmz = kCmy + 3,
    kDampingRate = kCmz + 3,
    kSpeedFloor = kDampingRate + 3,
    kReDrag,
    kReLift,
    kNu,
    kLength,
    kParameters
  };
  enum Term { kInertial, kDrag, kSideForce, kLift, kMoment, kDamping, kThrust, kGravity, kTerms };

  static ModelInfo info() {
    return {
        .name = "coefficient_body",
        .title = "Body with polynomial lift, drag and moment coefficients, two thrusts and an offset mass",
        .equations =
            "dP/dt = P x w + F;  "
            "dL/dt = L x w + P x u + T;  "
            "(P, L) = (M_body + K) (u, w);  "
            "(x, y, z)' = R u;  "
            "q' = 1/2 q (0, w);  "
            "F = E (-drag, side, -lift) + (thrust_left + thrust_right, 0, 0) + (mass + offset_mass - "
            "displaced_mass) R^T (0, 0, -g);  "
            "T = E (moments + damping) + (0, (thrust_left + thrust_right) offset_z, (thrust_left - "
            "thrust_right) thrust_arm) + (mass r_c + offset_mass offset) x R^T (0, 0, -g);  "
            "drag = Q (1 + Re_drag/Re) (Cd0 + Cda alpha^2 + Cdb beta^2);  "
            "side = Q/(1 + Re_lift/Re) (Cs0 + Csa alpha^2 + Csb beta);  "
            "lift = Q/(1 + Re_lift/Re) (Cl0 + Cla alpha + Clb beta^2);  "
            "moments = Q/(1 + Re_lift/Re) (Cmx0 + Cmxa alpha + Cmxb beta, Cmy0 + Cmya alpha + Cmyb beta^4, "
            "Cmz0 + Cmza "
            "alpha + Cmzb beta);  "
            "damping = (K1 w_x, K2 w_y, K3 w_z);  "
            "Q = 1/2 fluid_density area |u|^2;  "
            "Re = length sqrt(|u|^2 + speed_floor^2)/nu;  "
            "alpha = 2 atan2(u_z, u_x + v);  "
            "beta = atan2(u_y, v);  "
            "v = sqrt(u_x^2 + u_z^2 + speed_floor^2);  "
            "E: the axes of flow, body x, y, z turned by beta about z, then by -alpha about y;  "
            "K = diag(M_x, M_y, M_z, J_x, J_y, J_z)",
        .frames =
            "world: z up; body: x forward, y to the right, z down, origin at the centre of buoyancy, so that "
            "level flight along world x has q = (0, 1, 0, 0). Axes of flow: x along u, z down in the plane "
            "of symmetry; drag acts along -x, side force along y, lift along -z; alpha is "
            "atan2(u_z, u_x) but for the floor. Data with z down (x north, "
            "y east) turn into this world by a half turn about x",
        .source =
            "Y. Zhu, H. Cheng, F. Zhang, IEEE Robot. Autom. Lett. 9 (2024) 10986-10993, whose fitted "
            "coefficients go by these names",
        .validity =
            "flow from the front, angles up to about 0.6; coefficients are those of one body (area and "
            "lengths included). Damping is along the axes of flow, as in the source, and is passive for "
            "K <= 0 and small angles only. Buoyancy acts at the origin",
        .symmetries = upright_symmetries(),
        .states = pose_states(),
        .parameters = parameters(),
        .affine_in = affine_parameters(),
        .force_terms = {{.name = "inertia", .description = "P x w and L x w + P x u"},
                        {.name = "drag", .description = "against the flow"},
                        {.name = "side force", .description = "along y of the flow"},
                        {.name = "lift", .description = "against z of the flow"},
                        {.name = "moment", .description = "of the flow"},
                        {.name = "damping", .description = "of rotation"},
                        {.name = "thrust", .description = "of the two propellers, along body x"},
                        {.name = "gravity and buoyancy", .description = "weights at their places"}},
        .groups = pose_groups(),
    };
  }

  static Parameters coefficients() {
    Parameters list;
    for (const char* name : {"Cd0", "Cda", "Cdb"}) list.push_back(any_value(name, "1", 0.0, "of the drag"));
    for (const char* name : {"Cs0", "Csa", "Csb"})
      list.push_back(any_value(name, "1", 0.0, "of the side force"));
    for (const char* name : {"Cl0", "Cla", "Clb"}) list.push_back(any_value(name, "1", 0.0, "of the lift"));
    for (const char* name : {"Cmx0", "Cmxa", "Cmxb"})
      list.push_back(any_value(name, "m", 0.0, "of the roll moment"));
    for (const char* name : {"Cmy0", "Cmya", "Cmyb"})
      list.push_back(any_value(name, "m", 0.0, "of the pitch moment"));
    for (const char* name : {"Cmz0", "Cmza", "Cmzb"})
      list.push_back(any_value(name, "m", 0.0, "of the yaw moment"));
    for (const char* name : {"K1", "K2", "K3"}) {
      list.push_back(any_value(name, "N m s", 0.0, "torque over rate, negative for damping"));
    }
    return list;
  }

  static std::vector<std::string> affine_parameters() {
    std::vector<std::string> names = {"thrust_left", "thrust_right"};
    for (const ParameterInfo& coefficient : coefficients()) names.push_back(coefficient.name);
    return names;
  }

  static Parameters parameters() {
    Parameters list = {
        positive("mass", "kg", "mass without the offset mass"),
        positive("I_x", "kg m^2", "moment of inertia of that mass about body x through the origin"),
        positive("I_y", "kg m^2", "moment of inertia of that mass about body y through the origin"),
        positive("I_z", "kg m^2", "moment of inertia of that mass about body z through the origin"),
        any_value("r_cx", "m", 0.0, "centre of that mass, body x"),
        any_value("r_cy", "m", 0.0, "centre of that mass, body y"),
        any_value("r_cz", "m", 0.0, "centre of that mass, body z"),
        not_negative("offset_mass", "kg", 0.0, "a point mass, such as a gondola"),
        any_value("offset_x", "m", 0.0, "its place, body x"),
        any_value("offset_y", "m", 0.0, "its place, body y"),
        any_value("offset_z", "m", 0.0, "its place, body z; the thrusts act at this height"),
        not_negative("displaced_mass", "kg", 0.0, "mass of the displaced fluid"),
        with_default(positive("fluid_density", "kg/m^3",
                              "density of the fluid; default: air at 20 degrees C and 1 "
                              "atm, rounded"),
                     1.2),
        not_negative("g", "m/s^2", 9.81, "gravitational acceleration"),
        positive("area", "m^2", "reference area of all coefficients"),
    };
    for (const char* name : {"M_x", "M_y", "M_z"})
      list.push_back(not_negative(name, "kg", 0.0, "added mass"));
    for (const char* name : {"J_x", "J_y", "J_z"}) {
      list.push_back(not_negative(name, "kg m^2", 0.0, "added moment of inertia"));
    }
    append(list, {any_value("thrust_left", "N", 0.0, "constant thrust of the left propeller"),
                  any_value("thrust_right", "N", 0.0, "constant thrust of the right propeller"),
                  any_value("thrust_arm", "m", 0.0,
                            "sideways distance of each propeller from the plane of symmetry")});
    append(list, coefficients());
    list.push_back(with_default(positive("speed_floor", "m/s",
                                         "speed below which the angles of flow are smoothed: "
                                         "they are undefined at rest"),
                                1e-6));
    append(list, {Re_drag("Re = length |u|/nu"), Re_lift(), viscosity_of_air(),
                  derived("length", "m", "sqrt(area)", "of Re", false)});
    return list;
  }

  template <class S>
  static SpatialInertia<S> total_inertia(const S* p) {
    SpatialInertia<S> total;
    total.add_mass(p[kOffsetMass], vector3(p + kOffset));
    total.add_linear_mass(p[kMass], vector3(p + kMassCentre));
    for (int i = 0; i < 3; ++i) {
      total.add(i, i, p[kAddedMass + i]);
      total.add(3 + i, 3 + i, p[kInertia + i] + p[kAddedInertia + i]);
    }
    return total;
  }

  /// Drag, side force, lift, moment and damping, from `first` on.
  template <class S>
  static void aerodynamic_loads(const Pose<S>& pose, const Vector3<S>& w_r, const S* p, Load<S>* first) {
    using std::sqrt;
    const FlowAxes<S> flow(pose.u, p[kSpeedFloor]);
    const S &alpha = flow.alpha, &beta = flow.beta;
    const S alpha_2 = alpha * alpha, beta_2 = beta * beta;
    const S q = S(0.5) * p[kFluidDensity] * p[kArea] * flow.speed_2;
    const S U = sqrt(flow.speed_2 + p[kSpeedFloor] * p[kSpeedFloor]);
    const ReynoldsSpeeds<S> Re = reynolds_speeds(p[kReDrag], p[kReLift], p[kNu], p[kLength]);
    const S q_drag = q * drag_speed(U, Re.drag) / U;
    const S q_lift = q * U / (U + Re.lift);
    const auto coefficient = [p](int which, const S& of_alpha, const S& of_beta) {
      return p[which] + p[which + 1] * of_alpha + p[which + 2] * of_beta;
    };
    first[0].force = -(q_drag * coefficient(kCd, alpha_2, beta_2)) * flow.x;
    first[1].force = (q_lift * coefficient(kCs, alpha_2, beta)) * flow.y;
    first[2].force = -(q_lift * coefficient(kCl, alpha, beta_2)) * flow.z;
    first[3].torque =
        q_lift * flow.to_body({coefficient(kCmx, alpha, beta), coefficient(kCmy, alpha, beta_2 * beta_2),
                               coefficient(kCmz, alpha, beta)});
    first[4].torque = flow.to_body(diagonal_times(vector3(p + kDampingRate), w_r));
  }

  template <class S>
  static Load<S> weights(const Pose<S>& pose, const S* p) {
    const Vector3<S> g_b = pose.R.to_body({S(0.0), S(0.0), -p[kG]});
    const Load<S> body = force_at(vector3(p + kMassCentre), p[kMass] * g_b);
    const Load<S> offset = force_at(vector3(p + kOffset), p[kOffsetMass] * g_b);
    return body + offset + Load<S>{-p[kDisplacedMass] * g_b, {}};
  }

  template <class S>
  static Load<S> thrust(const S* p) {
    const S sum = p[kThrustLeft] + p[kThrustRight];
    const S difference = p[kThrustLeft] - p[kThrustRight];
    return {{sum, S(0.0), S(0.0)}, {S(0.0), sum * p[kOffset + 2], difference * p[kThrustArm]}};
  }

  template <class S>
  static std::array<Load<S>, kTerms> loads(const Pose<S>& pose, const Vector3<S>& w_r,
                                           const SpatialInertia<S>& inertia, const S* p) {
    std::array<Load<S>, kTerms> all;
    all[kInertial] = gyroscopic_load(inertia.momentum(pose.u, pose.w), pose.u, pose.w);
    aerodynamic_loads(pose, w_r, p, &all[kDrag]);
    all[kThrust] = thrust(p);
    all[kGravity] = weights(pose, p);
    return all;
  }

  template <class S>
  static PlacedMasses<S> masses(const S* p) {
    // Buoyancy acts at the origin.
    return {p[kMass] + p[kOffsetMass],
            p[kDisplacedMass],
            p[kMass] * vector3(p + kMassCentre) + p[kOffsetMass] * vector3(p + kOffset),
            {S(0.0), S(0.0), S(0.0)}};
  }

  static void say_gusts(ModelInfo& info) {
    info.title = "Body with polynomial coefficients and two thrusts in a fluid that changes in time";
    std::string& text = info.equations;
    replace_in(text, "P x u + T", "P x u_r + T");
    replace_in(text, "(M_body + K) (u, w)", "(M_body + K) (u_r, w)");
    replace_in(text, "R^T (0, 0, -g);  T =",
               "R^T (0, 0, -g) + displaced_mass R^T a_f - (mass + offset_mass) R^T dw_air/dt - R^T W^T R "
               "P_f;  T =");
    replace_in(text, "(mass r_c + offset_mass offset) x R^T (0, 0, -g)",
               "(mass r_c + offset_mass offset) x R^T ((0, 0, -g) - dw_air/dt)");
    replace_in(text, "(K1 w_x, K2 w_y, K3 w_z)", "(K1 w_rx, K2 w_ry, K3 w_rz)");
    replace_in(text, "|u|", "|u_r|");
    replace_in(text, "atan2(u_z, u_x + v)", "atan2(u_rz, u_rx + v)");
    replace_in(text, "atan2(u_y, v)", "atan2(u_ry, v)");
    replace_in(text, "sqrt(u_x^2 + u_z^2", "sqrt(u_rx^2 + u_rz^2");
    text += kGustEquations;
  }

  template <class S>
  static void complete(const char* given, S* p) {
    using std::sqrt;
    if (!given[kLength]) p[kLength] = sqrt(p[kArea]);
  }

  static Scales scales(const double* p) {
    const double mass = p[kMass] + p[kOffsetMass];
    const double drive = (mass - p[kDisplacedMass]) * p[kG] + p[kThrustLeft] + p[kThrustRight];
    const double k = 0.5 * p[kFluidDensity] * p[kArea] * std::max(kLeastDragCoefficient, std::abs(p[kCd]));
    return body_scales(std::sqrt(p[kArea]), drive, mass, k);
  }
};

}  // namespace

std::shared_ptr<const Model> coefficient_body() {
  return std::make_shared<LawModel<CoefficientBody>>();
}

std::shared_ptr<const Model> coefficient_body_in_gusts() {
  return std::make_shared<LawModel<SpatialBodyInGusts<CoefficientBody>>>();
}

}  // namespace samara::models::laws
