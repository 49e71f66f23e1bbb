#pragma once

#include <numbers>

#include "bodies_in_flow.h"

/// The card of dissertation Figure 5.6: 7 cm x 4 cm x 0.2 mm in air, released at rest at 10 degrees about a
/// horizontal axis, with the four sets of coefficients that the figure names after their motion.

struct Pattern {
  double C_D90, C_T, C_R;
};
constexpr Pattern kSteadyDescent = {1.81, 0.31, 0.31};
constexpr Pattern kZigzag = {0.31, 0.91, 0.61};
constexpr Pattern kAlternating = {0.61, 1.81, 1.21};
constexpr Pattern kAutorotation = {0.61, 2.71, 0.91};

const Eigen::Vector3d kAboutX = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kAboutY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kOblique = {std::cos(0.6), std::sin(0.6), 0.0};

using Values = std::map<std::string, double>;

/// Damping by each axis alone and small floors.
const Values kEachAxis = {{"damping_isotropy", 0.0}, {"speed_floor", 1e-3}, {"rate_floor", 0.05}};

/// What makes an aluminium card of 0.8 mm in water of it.
const Values kInWater = {{"c", 4e-4}, {"density", 2700.0}, {"fluid_density", 1000.0}, {"speed_floor", 1e-3}};

inline Values card_of(const Pattern& pattern, const Values& more = {}) {
  Values values = {{"a", 0.035},
                   {"b", 0.02},
                   {"c", 1e-4},
                   {"density", 1200.0},
                   {"C_D90", pattern.C_D90},
                   {"C_D0", 0.05},
                   {"C_T", pattern.C_T},
                   {"C_R", pattern.C_R},
                   {"C_w", 2.0}};
  for (const auto& [name, value] : more) values[name] = value;
  return values;
}

inline BodyState released_about(const Eigen::Vector3d& axis) {
  BodyState start;
  start.q = Eigen::AngleAxisd(10.0 * std::numbers::pi / 180.0, axis);
  return start;
}
