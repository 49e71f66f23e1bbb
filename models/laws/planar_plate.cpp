#include "samara/models/laws/planar_plate.h"

#include <algorithm>

namespace samara::models::laws {

std::vector<ForceTermInfo> planar_force_terms() {
  return {
      {.name = "inertia",
       .description = "gyroscopic forces and Munk's moment, of the body and its added mass; no power in all"},
      {.name = "translational lift", .description = "circulation by the angle of attack, C_T; no power"},
      {.name = "rotational lift", .description = "circulation by rotation, C_R; no power"},
      {.name = "drag", .description = "against the velocity; takes power"},
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

Scales plate_scales(double length, double speed) {
  constexpr double kLeastSpeed = 1e-6;  // m/s: slower bodies move by what is not in the models
  const double velocity = std::max(speed, kLeastSpeed);
  return {.length = length, .time = length / velocity, .velocity = velocity};
}

}  // namespace samara::models::laws
