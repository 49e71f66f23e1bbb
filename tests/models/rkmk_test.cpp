#include "samara/models/integrators/rkmk.h"

#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "falling_card.h"
#include "kirchhoff_ellipsoid.h"
#include "samara/base/errors.h"
#include "samara/models/integrators/adaptive.h"
#include "samara/models/integrators/lie_group_model.h"
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

TEST_CASE("models of one rigid body are integrated on the group, to order four") {
  std::map<std::string, double> heavy = {
      {"mass", 1.0}, {"I_xx", 0.4},  {"I_yy", 0.6},           {"I_zz", 0.9},  {"r_cz", -0.05}, {"K_11", 0.1},
      {"K_33", 0.6}, {"K_15", 0.05}, {"displaced_mass", 0.9}, {"wx(0)", 1.0}, {"uy(0)", 0.4}};
  const ParametricModel bodies[] = {{find_model("immersed_body"), ellipsoid_421_values(), {}},
                                    {find_model("kirchhoff_body"), heavy, {}}};
  for (const ParametricModel& body : bodies) {
    INFO(body.model().info().name);
    const std::array times = {0.7, 2.0};
    const Trajectory reference = integrate_adaptive(body, {}, times, {.relative_tolerance = 1e-13});
    const auto error = [&](double step) {
      const Trajectory found = LieGroupModelIntegrator(body, {.step = step, .order = 4})({}, times);
      REQUIRE(found.is_usable());
      return (found.states - reference.states).norm();
    };
    const double coarse = error(0.02), fine = error(0.01);
    CHECK_THAT(std::log2(coarse / fine), WithinAbs(4.0, 0.3));
    CHECK(fine < 1e-5);
  }
}

TEST_CASE("the integrator on the group refuses models that are no rigid body") {
  const ParametricModel point(find_model("quadratic_drag_fall"), {}, {"C_D", "area", "mass"});
  CHECK_THROWS_WITH(LieGroupModelIntegrator(point), Catch::Contains("expected a model of one rigid body"));
  CHECK_THROWS_AS(
      LieGroupModelIntegrator({find_model("immersed_body"), ellipsoid_421_values(), {}}, {.step = 0.0}),
      samara::ArgumentError);
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
