#pragma once

#include <string>

#include "samara/motion/sweeps/sweep.h"
#include "tests/error_text.h"

// A sweep that takes milliseconds: what tests of sweeps and maps share.
namespace samara::motion {

/// Thin plates from flutter to tumbling and chaos.
inline const std::string kPlates = R"(model = "falling_plate_nd"
[fixed]
beta = 0
[axes]
inertia_ratio = { from = 0.8, to = 2.4, count = 9 }
C_R = [1.4, 3.14159]
[releases]
tilt = [0.4, "40 deg"]
[run]
until = 120
step = 0.05
settle = 60
)";

inline SweepPlan plates(const std::string& more = "", const std::string& from = "",
                        const std::string& to = "") {
  std::string text = kPlates + more;
  if (!from.empty()) text.replace(text.find(from), from.size(), to);
  return parse_sweep_plan(text, "sweep.toml");
}

inline std::string refusal(const std::string& from, const std::string& to) {
  return error_text<samara::InputError>([&] { plates("", from, to); });
}

/// To the bit, or both not known.
inline bool are_same(double first, double second) {
  return first == second || (std::isnan(first) && std::isnan(second));
}

}  // namespace samara::motion
