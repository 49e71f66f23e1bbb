#include "samara/models/bodies/kinematic_paths.h"

#include <cmath>
#include <initializer_list>

#include "samara/base/errors.h"
#include "samara/base/number_text.h"
#include "samara/base/require.h"

namespace samara::models {

namespace {

struct Named {
  const char* name;
  double value;
};

void need_finite(std::initializer_list<Named> list) {
  for (const auto& [name, value] : list) {
    if (std::isfinite(value)) continue;
    throw ArgumentError(std::string(name) + " is " + number_text(value) + "; a finite number was expected");
  }
}

void need_positive(std::initializer_list<Named> list) {
  for (const auto& [name, value] : list) require_positive(value, name);
}

void check(const SideToSidePath& path) {
  need_finite({{"x0", path.x0},
               {"z0", path.z0},
               {"descent_speed", path.descent_speed},
               {"horizontal_speed", path.horizontal_speed},
               {"vertical_speed", path.vertical_speed}});
  need_positive({{"angular_frequency", path.angular_frequency}});
}

void check(const RosePath& path) {
  need_finite({{"z0", path.z0},
               {"descent_speed", path.descent_speed},
               {"amplitude_x", path.amplitude_x},
               {"amplitude_y", path.amplitude_y},
               {"modulation", path.modulation},
               {"lobes", path.lobes}});
  need_positive({{"angular_frequency", path.angular_frequency}});
}

}  // namespace

PathPoint at(const SideToSidePath& path, double t) {
  check(path);
  need_finite({{"t", t}});
  const double W = path.angular_frequency;
  PathPoint point;
  point.position.x() = path.x0 - path.horizontal_speed / W * std::sin(W * t);
  point.position.z() =
      path.z0 - path.descent_speed * t - path.vertical_speed / (2.0 * W) * std::cos(2.0 * W * t);
  point.velocity.x() = -path.horizontal_speed * std::cos(W * t);
  point.velocity.z() = -path.descent_speed + path.vertical_speed * std::sin(2.0 * W * t);
  return point;
}

PathPoint at(const RosePath& path, double t) {
  check(path);
  need_finite({{"t", t}});
  const double W = path.angular_frequency;
  const double kW = path.lobes * W;
  const double c = std::cos(W * t);
  const double s = std::sin(W * t);
  const double r = 1.0 + path.modulation * std::sin(kW * t);
  const double r_rate = path.modulation * kW * std::cos(kW * t);
  PathPoint point;
  point.position = {path.amplitude_x * c * r, path.amplitude_y * s * r, path.z0 - path.descent_speed * t};
  point.velocity = {path.amplitude_x * (c * r_rate - W * s * r), path.amplitude_y * (s * r_rate + W * c * r),
                    -path.descent_speed};
  return point;
}

}  // namespace samara::models
