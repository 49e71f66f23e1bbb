#include "samara/models/laws/rigid_body.h"

#include <algorithm>

namespace samara::models::laws {

std::vector<StateInfo> pose_states() {
  return {
      {.name = "x", .unit = "m", .description = "position of the origin, world"},
      {.name = "y", .unit = "m", .description = "position of the origin, world"},
      {.name = "z", .unit = "m", .description = "position of the origin, world, up"},
      {.name = "qw",
       .unit = "1",
       .default_initial = 1.0,
       .description = "attitude quaternion, body to world"},
      {.name = "qx", .unit = "1", .description = "attitude quaternion, body to world"},
      {.name = "qy", .unit = "1", .description = "attitude quaternion, body to world"},
      {.name = "qz", .unit = "1", .description = "attitude quaternion, body to world"},
      {.name = "ux", .unit = "m/s", .description = "velocity of the origin along body x"},
      {.name = "uy", .unit = "m/s", .description = "velocity of the origin along body y"},
      {.name = "uz", .unit = "m/s", .description = "velocity of the origin along body z"},
      {.name = "wx", .unit = "rad/s", .description = "angular velocity about body x"},
      {.name = "wy", .unit = "rad/s", .description = "angular velocity about body y"},
      {.name = "wz", .unit = "rad/s", .description = "angular velocity about body z"},
  };
}

std::vector<StateGroup> pose_groups() {
  return {{.kind = StateGroupKind::position, .first = kPosition},
          {.kind = StateGroupKind::quaternion, .first = kQw}};
}

std::vector<std::string> translations() {
  return {"translation of x", "translation of y", "translation of z"};
}

std::vector<std::string> upright_symmetries() {
  std::vector<std::string> all = translations();
  all.push_back("rotation about z");
  return all;
}

Scales body_scales(double length, double drive, double mass, double k) {
  const double force = std::max(std::abs(drive), 1e-3 * kStandardGravity * mass);
  const double velocity = std::sqrt(force / k);
  return {.length = length, .time = length / velocity, .velocity = velocity};
}

}  // namespace samara::models::laws
