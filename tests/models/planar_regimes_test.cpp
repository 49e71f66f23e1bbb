// Model sheet, section 3: the regimes of the dimensionless thin plate, by statistics of long falls.
#include <array>
#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "samara/models/parametric_model.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kPi = std::numbers::pi;

struct Statistics {
  double mean_vx = 0.0;  ///< in the world
  double mean_vy = 0.0;
  double range = 0.0;  ///< of theta
  double turns_per_100 = 0.0;
  double period = 0.0;  ///< between swings to the same side
};

/// RK4 with the step 4e-3 from t = 0 (theta = 0.4), statistics over the second half of 1200.
Statistics fall(const std::map<std::string, double>& fixed) {
  using State = Eigen::Matrix<double, 6, 1>;
  std::map<std::string, double> all = {{"beta", 0.0}};
  all.insert(fixed.begin(), fixed.end());
  const ParametricModel model(find_model("falling_plate_nd"), all, {});
  ParametricModel::Workspace workspace = model.make_workspace();
  const auto rate = [&](const State& x) {
    State dxdt;
    model.rhs(0.0, {x.data(), 6}, {}, {dxdt.data(), 6}, workspace);
    return dxdt;
  };
  const double h = 4e-3;
  const int steps = 300000;
  State x;
  model.initial({}, {x.data(), 6});
  State begin;
  double lowest = 0.0, highest = 0.0, first_swing = 0.0, last_swing = 0.0;
  int swings = 0;
  for (int k = 0; k < steps; ++k) {
    if (k == steps / 2) {
      begin = x;
      lowest = highest = x[3];
    }
    const State k1 = rate(x);
    const State k2 = rate(x + h / 2 * k1);
    const State k3 = rate(x + h / 2 * k2);
    const State k4 = rate(x + h * k3);
    const State next = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    if (k >= steps / 2) {
      lowest = std::min(lowest, next[3]);
      highest = std::max(highest, next[3]);
      if (x[2] < 0.0 && next[2] >= 0.0) {
        last_swing = h * (k - x[2] / (next[2] - x[2]));
        if (swings++ == 0) first_swing = last_swing;
      }
    }
    x = next;
  }
  const double time = h * (steps - steps / 2);
  return {.mean_vx = (x[4] - begin[4]) / time,
          .mean_vy = (x[5] - begin[5]) / time,
          .range = highest - lowest,
          .turns_per_100 = 100.0 * (x[3] - begin[3]) / (2.0 * kPi) / time,
          .period = swings > 1 ? (last_swing - first_swing) / (swings - 1) : 0.0};
}

}  // namespace

// Tolerances: one unit of the last digit that the sheet states, and for means over 600 units of time what a
// part of a period may add (a swing of about 2 in x or y over 600: 0.004). The sheet's periods are means over
// runs that include the start; those of the final motion, the same to five digits for steps of 8e-3 and 2e-3
// and for two starts, are up to 0.25 % off them.

TEST_CASE("light plates flutter, slower in swing and faster in fall the heavier they are") {
  const Statistics light = fall({{"inertia_ratio", 0.5}});
  CHECK_THAT(light.mean_vy, WithinAbs(-0.301, 0.004));
  CHECK_THAT(light.range, WithinAbs(1.48, 0.01));
  CHECK_THAT(light.period, WithinRel(6.37, 2.5e-3));
  const Statistics reference = fall({{"inertia_ratio", 1.1}});
  CHECK_THAT(reference.mean_vy, WithinAbs(-0.585, 0.005));
  CHECK_THAT(reference.range, WithinAbs(3.04, 0.01));
  CHECK_THAT(reference.period, WithinAbs(15.9530, 1e-4));
  CHECK_THAT(reference.period, WithinRel(15.957, 2.5e-3));
}

TEST_CASE("the plate of inertia ratio 1.4 tumbles and drifts to one side") {
  const Statistics tumbling = fall({{"inertia_ratio", 1.4}});
  CHECK_THAT(std::abs(tumbling.turns_per_100), WithinAbs(7.79, 0.1));
  CHECK_THAT(std::abs(tumbling.mean_vx), WithinAbs(0.756, 0.005));
  CHECK_THAT(tumbling.mean_vy, WithinAbs(-0.327, 0.005));
}

TEST_CASE("heavy plates flutter about broadside again, and fall fast") {
  const Statistics heavy = fall({{"inertia_ratio", 4.0}});
  CHECK_THAT(heavy.mean_vy, WithinAbs(-1.158, 0.005));
  CHECK_THAT(heavy.range, WithinAbs(1.59, 0.01));
  CHECK_THAT(heavy.period, WithinRel(7.18, 2.5e-3));
}

TEST_CASE("without enough rotational lift nothing tumbles") {
  for (const double inertia_ratio : {1.1, 1.4, 2.0, 3.0}) {
    const Statistics small = fall({{"inertia_ratio", inertia_ratio}, {"C_R", 1.4}});
    CHECK(small.range < 0.6);
    CHECK_THAT(small.turns_per_100, WithinAbs(0.0, 0.1));
  }
}
