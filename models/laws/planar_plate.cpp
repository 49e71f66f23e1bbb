#include "samara/models/laws/planar_plate.h"

#include <numbers>

namespace samara::models::laws {

std::vector<ForceTermInfo> planar_force_terms() {
  return {
      {.name = "inertia",
       .description = "gyroscopic forces and Munk's moment, of the body and its added mass; no power in all"},
      {.name = "translational lift", .description = "circulation by the angle of attack, C_T; no power"},
      {.name = "rotational lift", .description = "circulation by rotation, C_R; no power"},
      {.name = "drag", .description = "against the velocity; takes power where A > |B|"},
      {.name = "dissipation", .description = "torque against the rotation; takes power"},
      {.name = "gravity and buoyancy", .description = "weight less that of the displaced fluid"},
  };
}

std::vector<StateInfo> planar_states() {
  return {
      {.name = "vx", .unit = "m/s", .description = "velocity along the chord x'"},
      {.name = "vy", .unit = "m/s", .description = "velocity along the normal y'"},
      {.name = "w", .unit = "rad/s", .description = "rotation rate, theta'"},
      {.name = "theta",
       .unit = "rad",
       .default_initial = 0.4,
       .description = "angle of x' above the horizontal"},
      {.name = "x", .unit = "m", .description = "horizontal position"},
      {.name = "y", .unit = "m", .description = "height, positive upward"},
  };
}

Parameters elliptic_plate_coefficients() {
  return {
      any_value("C_T", "1", 1.2, "translational lift"),
      any_value("C_R", "1", std::numbers::pi, "rotational lift"),
      any_value("A", "1", 1.4, "mean drag on the chord: A - B edge-on, A + B broadside"),
      any_value("B", "1", 1.0, "drag by the angle of attack"),
      not_negative("mu1", "1", 0.2, "linear dissipation of rotation"),
      derived("mu2", "1", "mu1", "quadratic dissipation of rotation: freeing mu1 alone moves both", true),
  };
}

ParameterInfo water() {
  return with_default(
      positive("fluid_density", "kg/m^3", "density of the fluid; default: water at 20 degrees C"), 998.2);
}

ParameterInfo gravity() {
  return with_default(positive("g", "m/s^2", "gravitational acceleration"), 9.81);
}

}  // namespace samara::models::laws
