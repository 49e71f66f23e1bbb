#include "samara/models/laws/immersed_body.h"

#include <algorithm>

#include "samara/models/law_tools/parameter_list.h"

namespace samara::models::laws {

namespace {

/// Defaults: the published falling plate of Andersen et al. (C_T 1.2, C_R pi, A 1.4, B 1.0, mu2 0.2), with
/// C_D0 = A - B, C_D90 = A + B, C_w = 4 pi mu2.
Parameters coefficient_parameters() {
  return {
      not_negative("C_D0", "1", 0.4, "drag coefficient edge-on, on the area pi a b"),
      not_negative("C_D90", "1", 2.4, "drag coefficient broadside, on the area pi a b"),
      not_negative("C_T", "1", 1.2, "coefficient of translational lift"),
      not_negative("C_R", "1", std::numbers::pi, "coefficient of rotational lift"),
      not_negative("C_w", "1", 0.8 * std::numbers::pi, "coefficient of rotational damping"),
      share("damping_isotropy", 1.0, "1: damping by the speed of the rim; 0: by each axis"),
      not_negative("linear_damping_x", "N m s", 0.0, "damping torque over rate about body x"),
      not_negative("linear_damping_y", "N m s", 0.0, "damping torque over rate about body y"),
      not_negative("linear_damping_z", "N m s", 0.0, "skin friction: torque over rate about body z"),
      share("centre_of_pressure", 0.0,
            "share of the offset (1 - sin_alpha^3) l/4 of the centre of pressure; with 1, the Munk "
            "moment counts attached flow a second time: lower kappa"),
      share("kappa", 1.0, "factor of the Munk moment (M u_r) x u_r, 0 to 1"),
      share("velocity_chord", 0.0,
            "chord of the rotational lift. 0: the plate's own about each axis; 1: along the velocity, with "
            "kinks"),
  };
}

Parameters smoothness_parameters() {
  return {
      with_default(positive("speed_floor", "m/s", "speed below which forces are smoothed"), 0.02),
      with_default(positive("rate_floor", "rad/s", "rate below which damping is smoothed"), 1.0),
      Re_drag("Re = 2 a |u_r|/nu"),
      Re_lift(),
      viscosity_of_air(),
  };
}

std::vector<ForceTermInfo> force_terms() {
  return {
      {.name = "inertia",
       .description = "P_r x w, and L x w + kappa (M u_r) x u_r, with the momentum relative to "
                      "the fluid P_r = (m + M) u_r"},
      {.name = "drag", .description = "against u_r"},
      {.name = "translational lift",
       .description = "perpendicular to u_r, in the plane of u_r and the normal"},
      {.name = "rotational lift", .description = "perpendicular to u_r and to the in-plane rotation"},
      {.name = "damping", .description = "of rotation"},
      {.name = "gravity and buoyancy", .description = "weight at the origin, buoyancy at r_b"},
      {.name = "ambient acceleration",
       .description =
           "pressure gradient of the undisturbed fluid, m_f D w_air/Dt at r_b, "
           "less m times the rate of w_air along the path, and -R^T W^T R M u_r by its gradient W"},
  };
}

}  // namespace

ModelInfo ImmersedBody::info() {
  ModelInfo info;
  info.equations =
      "(m + M) u_r' = ((m + M) u_r) x w + F + R^T (m_f Dw_air/Dt - m dw_air/dt - W^T R M u_r);  "
      "(I + J) w' = ((I + J) w) x w + kappa (M u_r) x u_r + T;  "
      "u' = u_r' + d(R^T w_air)/dt;  "
      "(x, y, z)' = R u;  "
      "q' = 1/2 q (0, w);  "
      "u_r = u - R^T w_air;  "
      "F = drag + translational lift + rotational lift + (m - m_f) R^T (0, 0, -g);  "
      "T = p x (drag + translational lift + rotational lift) + damping - m_f r_b x R^T ((0, 0, -g) - "
      "Dw_air/Dt);  "
      "drag = -1/2 rho A (1 + Re_drag/Re) (C_D0 (v_x^2 + v_y^2) + C_D90 v_z^2)/U v;  "
      "translational lift = -rho A C_T/(1 + Re_lift/Re) v_z/U v x (n x v);  "
      "rotational lift = 1/2 rho A C_R/(1 + Re_lift/Re) (l_x w_x, l_y w_y, 0) x v;  "
      "damping = -(4/15 rho C_w a b^3 s_x w_x, 4/15 rho C_w b a^3 s_y w_y, 0) - (linear_damping_x w_x, "
      "linear_damping_y w_y, linear_damping_z w_z);  "
      "v = u_r + w x p;  "
      "U = sqrt(|v|^2 + speed_floor^2);  "
      "Re = 2 a U/nu;  "
      "(l_x, l_y) = (1 - velocity_chord) (2 b, 2 a) + velocity_chord (l, l);  "
      "l = 2 a b sqrt(v_x^2 + v_y^2 + speed_floor^2)/h(v);  "
      "h(v) = sqrt(b^2 v_x^2 + a^2 v_y^2 + a b speed_floor^2);  "
      "p = centre_of_pressure (1 - sin_alpha^3) (a b/2) (u_rx, u_ry, 0)/h(u_r);  "
      "sin_alpha = |u_rz|/sqrt(|u_r|^2 + speed_floor^2);  "
      "s_x = i s + (1 - i) b sqrt(w_x^2 + rate_floor^2);  "
      "s_y = i s + (1 - i) a sqrt(w_y^2 + rate_floor^2);  "
      "s = sqrt(b^2 w_x^2 + a^2 w_y^2 + a b rate_floor^2);  "
      "i = damping_isotropy;  "
      "A = pi a b;  "
      "n = (0, 0, 1);  "
      "rho = fluid_density;  "
      "m = mass;  "
      "m_f = displaced_mass;  "
      "dw_air/dt along the path of the body, Dw_air/Dt along that of the fluid, W the gradient of w_air";
  info.frames =
      "world: z up; body: origin at the centre of mass, axes the principal ones, z the normal of the "
      "plate. x, y, z in the world; q turns body into world; u and w along body axes";
  info.source =
      "Kirchhoff's equations (H. Lamb, Hydrodynamics, 6th ed., 1932, art. 124); A. Andersen, U. "
      "Pesavento, Z. J. Wang, J. Fluid Mech. 541 (2005) 65-90 for the plane, carried to three dimensions; "
      "dissertation (5.12)-(5.19), corrected";
  info.validity =
      "flat bodies at Reynolds numbers of about 1e2 to 1e5 with quasi-steady forces: no wake, no history; "
      "unbounded fluid. The lift coefficients are fitted ones. The quaternion is normalised where it is "
      "used; its norm is constant but for the integrator's error";
  info.states = pose_states();
  info.groups = pose_groups();
  info.parameters = EllipsoidBody::parameters();
  append(info.parameters, coefficient_parameters());
  append(info.parameters, smoothness_parameters());
  info.affine_in = {
      "C_D0", "C_D90", "C_T", "C_R", "C_w", "linear_damping_x", "linear_damping_y", "linear_damping_z"};
  info.force_terms = force_terms();
  return info;
}

Scales ImmersedBody::scales(const double* p) {
  const double C_D = std::max(kLeastDragCoefficient, 0.5 * (p[kCD0] + p[kCD90]));
  const double k = 0.5 * p[kFluidDensity] * std::numbers::pi * p[kA] * p[kB] * C_D;
  return body_scales(2.0 * std::max(p[kA], p[kB]), (p[kMass] - p[kDisplacedMass]) * p[kG], p[kMass], k);
}

template <>
ModelInfo ImmersedBodyIn<StillFluid>::info() const {
  ModelInfo info = ImmersedBody::info();
  info.name = "immersed_body";
  info.title = "Body with quasi-steady forces in a fluid at rest";
  info.equations += ";  w_air = (0, 0, 0)";
  info.symmetries = upright_symmetries();
  return info;
}

std::shared_ptr<const Model> immersed_body() {
  return std::make_shared<LawModel<ImmersedBodyIn<StillFluid>>>();
}

}  // namespace samara::models::laws
