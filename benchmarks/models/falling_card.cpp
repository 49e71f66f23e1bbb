#include "falling_card.h"

#include <cmath>
#include <numbers>

#include "samara/models/laws/registry.h"

namespace samara::benchmarks {

models::ParametricModel oblique_card(double axis) {
  constexpr double kTilt = 10.0 * std::numbers::pi / 180.0;
  return {models::find_model("immersed_body"),
          {{"a", 0.035},
           {"b", 0.02},
           {"c", 1e-4},
           {"density", 1200.0},
           {"fluid_density", 1.2},
           {"C_D0", 0.05},
           {"C_w", 2.0},
           {"qw(0)", std::cos(0.5 * kTilt)},
           {"qx(0)", std::sin(0.5 * kTilt) * std::cos(axis)},
           {"qy(0)", std::sin(0.5 * kTilt) * std::sin(axis)},
           {"qz(0)", 0.0}},
          {"C_D90", "C_T", "C_R"}};
}

Eigen::MatrixXd coefficient_grid() {
  constexpr int kValues = 9;
  const auto value = [](int i) { return 0.31 + 0.3 * i; };
  Eigen::MatrixXd points(kValues * kValues * kValues, 3);
  Eigen::Index n = 0;
  for (int i = 0; i < kValues; ++i) {
    for (int j = 0; j < kValues; ++j) {
      for (int k = 0; k < kValues; ++k) points.row(n++) << value(i), value(j), value(k);
    }
  }
  return points;
}

}  // namespace samara::benchmarks
