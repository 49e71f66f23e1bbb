#include "samara/models/integrators/rkmk.h"

#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "falling_card.h"
#include "kirchhoff_ellipsoid.h"
#include "samara/base/errors.h"
#include "samara/models/integrators/adaptive.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;

namespace {

double quaternion_norm(const Trajectory& trajectory, Eigen::Index row) {
  return trajectory.states.row(row).segment(3, 4).norm();
}

}  // namespace

TEST_CASE("the Runge-Kutta-Munthe-Kaas method has order four") {
  const ParametricModel body(find_model("immersed_body"), ellipsoid_421_values(), {});
  const std::array times = {2.0};
  const Trajectory reference = integrate_adaptive(body, {}, times, {.relative_tolerance = 1e-13});
  const auto error = [&](double step) {
    return (integrate_rkmk(body, {}, times, {.step = step}).states - reference.states).norm();
  };
  CHECK_THAT(std::log2(error(0.04) / error(0.02)), WithinAbs(4.0, 0.2));
}

TEST_CASE("the Runge-Kutta-Munthe-Kaas method agrees with the reference on the falling card") {
  const ParametricModel card = falling_card({"C_R"});
  const std::array q = {1.21};
  const std::array times = {0.0, 0.1, 0.2};
  const Trajectory reference = integrate(card, q, times, {.relative_tolerance = 1e-12});
  const Trajectory trajectory = integrate_rkmk(card, q, times, {.step = 2.5e-4});
  REQUIRE(trajectory.is_usable());
  CHECK(trajectory.states.row(0) == reference.states.row(0));
  // 3e-6 at 1 ms and order four; the reference errs by 3e-9 (rk4_test).
  CHECK((trajectory.states - reference.states).cwiseAbs().maxCoeff() < 3e-8);
}

TEST_CASE("quaternions keep unit length at steps where they would not by themselves") {
  const ParametricModel body(find_model("immersed_body"), ellipsoid_421_values(), {});
  const std::array times = {10.0, 100.0};
  const Trajectory trajectory = integrate_rkmk(body, {}, times, {.step = 0.1});
  for (Eigen::Index row = 0; row < 2; ++row)
    CHECK_THAT(quaternion_norm(trajectory, row), WithinAbs(1.0, 4e-16));
}

TEST_CASE("the Runge-Kutta-Munthe-Kaas method refuses models without attitude, and steps without meaning") {
  const ParametricModel fall(find_model("quadratic_drag_fall"), {}, {"C_D", "area", "mass"});
  CHECK_THROWS_WITH(RkmkIntegrator(fall), Catch::Contains("has no quaternion among its states"));
  CHECK_THROWS_AS(RkmkIntegrator(falling_card({}), {.step = 0.0}), samara::ArgumentError);
}

TEST_CASE("the Runge-Kutta-Munthe-Kaas method stops where more steps than allowed would be needed") {
  for (const double step : {1e-20, 1e-300}) {
    const Trajectory trajectory = integrate_rkmk(falling_card({}), {}, std::array{1.0}, {.step = step});
    CHECK(trajectory.status == IntegrateStatus::too_many_steps);
    CHECK(std::isnan(trajectory.states(0, 0)));
  }
  const Trajectory part =
      integrate_rkmk(falling_card({}), {}, std::array{0.05, 0.2}, {.step = 1e-3, .max_steps = 100});
  CHECK(part.status == IntegrateStatus::too_many_steps);
  CHECK(part.reached == 0.05);
}
