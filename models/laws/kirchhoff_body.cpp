#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "samara/models/laws/spatial_body.h"

namespace samara::models::laws {

namespace {

struct KirchhoffBody : SpatialBody<KirchhoffBody> {
  static constexpr int kStates = kPoseStates;
  enum Parameter {
    kMass,
    kInertia,
    kMassCentre = kInertia + 6,
    kDisplacedMass = kMassCentre + 3,
    kBuoyancyCentre,
    kG = kBuoyancyCentre + 3,
    kK,
    kParameters = kK + 21
  };
  enum Term { kInertial, kGravity, kTerms };

  static ModelInfo info() {
    return {
        .name = "kirchhoff_body",
        .title = "Rigid body of any shape in an ideal fluid at rest",
        .equations =
            "dP/dt = P x w + F;  "
            "dL/dt = L x w + P x u + T;  "
            "(P, L) = (M_body + K) (u, w);  "
            "(x, y, z)' = R u;  "
            "q' = 1/2 q (0, w);  "
            "F = (mass - displaced_mass) R^T (0, 0, -g);  "
            "T = (mass r_c - displaced_mass r_b) x R^T (0, 0, -g)",
        .frames =
            "world: z up; body: axes and origin as chosen for K, the inertia and the centres. x, y, z of the "
            "origin in the world; q turns body into world; u (of the origin) and w along body axes",
        .source =
            "G. Kirchhoff; H. Lamb, Hydrodynamics, 6th ed., 1932, arts. 120-124; dissertation (2.12), "
            "(6.24). Its (4.4) prints v x (M w) for w x (M v) and conserves nothing",
        .validity =
            "no vorticity, no viscosity: bodies in their first moments after release, or parts of other "
            "models. (M_body + K) must be positive definite",
        .symmetries = upright_symmetries(),
        .states = pose_states(),
        .parameters = parameters(),
        .affine_in = {"g"},
        .force_terms = {{.name = "inertia", .description = "P x w and L x w + P x u of body and fluid"},
                        {.name = "gravity and buoyancy", .description = "weight at r_c, buoyancy at r_b"}},
        .groups = pose_groups(),
    };
  }

  static ParameterInfo moment(const char* name) {
    return {.name = name,
            .unit = "kg m^2",
            .description = "moment of inertia about the centre of mass",
            .lower = 0.0};
  }
  static ParameterInfo entry(const char* name) {
    return {
        .name = name,
        .unit = "kg m^2",
        .default_value = 0.0,
        .description = "entry of the inertia tensor about the centre of mass (minus the product of inertia)"};
  }
  static ParameterInfo coordinate(const char* name, const char* description) {
    return {.name = name, .unit = "m", .default_value = 0.0, .description = description};
  }

  static std::vector<ParameterInfo> parameters() {
    std::vector<ParameterInfo> list = {
        {.name = "mass", .unit = "kg", .description = "mass of the body", .lower = 0.0},
        moment("I_xx"),
        moment("I_yy"),
        moment("I_zz"),
        entry("I_xy"),
        entry("I_xz"),
        entry("I_yz"),
        coordinate("r_cx", "centre of mass, body x"),
        coordinate("r_cy", "centre of mass, body y"),
        coordinate("r_cz", "centre of mass, body z"),
        {.name = "displaced_mass",
         .unit = "kg",
         .default_value = 0.0,
         .description = "mass of the displaced fluid; default: none, as in vacuum",
         .lower = 0.0,
         .lower_inclusive = true},
        coordinate("r_bx", "centre of buoyancy, body x"),
        coordinate("r_by", "centre of buoyancy, body y"),
        coordinate("r_bz", "centre of buoyancy, body z"),
        {.name = "g",
         .unit = "m/s^2",
         .default_value = 9.81,
         .description = "gravitational acceleration",
         .lower = 0.0,
         .lower_inclusive = true},
    };
    for (int i = 1; i <= 6; ++i) {
      for (int j = i; j <= 6; ++j) list.push_back(added_mass_entry(i, j));
    }
    return list;
  }

  static ParameterInfo added_mass_entry(int i, int j) {
    const char* unit = j <= 3 ? "kg" : (i <= 3 ? "kg m" : "kg m^2");
    ParameterInfo info = {
        .name = fmt::format("K_{}{}", i, j),
        .unit = unit,
        .default_value = 0.0,
        .description = "added mass, entry of the symmetric matrix on (u, w); default: none"};
    if (i == j) {
      info.lower = 0.0;
      info.lower_inclusive = true;
    }
    return info;
  }

  template <class S>
  static SpatialInertia<S> total_inertia(const S* p) {
    SpatialInertia<S> total;
    total.add_mass(p[kMass], vector3(p + kMassCentre));
    total.add_rotational(p + kInertia);
    const S* K = p + kK;
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) total.add(i, j, *K++);
    }
    return total;
  }

  template <class S>
  static std::array<Load<S>, kTerms> loads(const Pose<S>& pose, const Vector3<S>&,
                                           const SpatialInertia<S>& inertia, const S* p) {
    Load<S> gravity =
        gravity_and_buoyancy(pose.R, p[kMass], p[kDisplacedMass], vector3(p + kBuoyancyCentre), p[kG]);
    const Vector3<S> weight = pose.R.to_body({S(0.0), S(0.0), -p[kMass] * p[kG]});
    gravity.torque = gravity.torque + cross(vector3(p + kMassCentre), weight);
    return {gyroscopic_load(inertia.momentum(pose.u, pose.w), pose.u, pose.w), gravity};
  }

  template <class S>
  static PlacedMasses<S> masses(const S* p) {
    return {p[kMass], p[kDisplacedMass], p[kMass] * vector3(p + kMassCentre),
            p[kDisplacedMass] * vector3(p + kBuoyancyCentre)};
  }

  static void say_gusts(ModelInfo& info) {
    info.title = "Rigid body of any shape in an ideal fluid that changes in time";
    std::string& text = info.equations;
    replace_in(text, "P x u + T", "P x u_r + T");
    replace_in(text, "(M_body + K) (u, w)", "(M_body + K) (u_r, w)");
    replace_in(text, "R^T (0, 0, -g);  T =",
               "R^T (0, 0, -g) + displaced_mass R^T a_f - mass R^T dw_air/dt - R^T W^T R P_f;  T =");
    replace_in(text, "(mass r_c - displaced_mass r_b) x R^T (0, 0, -g)",
               "mass r_c x R^T ((0, 0, -g) - dw_air/dt) - displaced_mass r_b x R^T ((0, 0, -g) - a_f)");
    text += kGustEquations;
  }

  /// Nothing resists the motion: the size of the body is its radius of gyration, its speed that of a fall by
  /// it.
  static Scales scales(const double* p) {
    const double trace = p[kInertia] + p[kInertia + 1] + p[kInertia + 2];
    const double length = std::sqrt(trace / p[kMass]);
    const double g = std::max(p[kG], 1e-3 * kStandardGravity);
    return {.length = length, .time = std::sqrt(length / g), .velocity = std::sqrt(length * g)};
  }
};

}  // namespace

std::shared_ptr<const Model> kirchhoff_body() {
  return std::make_shared<LawModel<KirchhoffBody>>();
}

std::shared_ptr<const Model> kirchhoff_body_in_gusts() {
  return std::make_shared<LawModel<SpatialBodyInGusts<KirchhoffBody>>>();
}

}  // namespace samara::models::laws
