#include "samara/models/integrators/adaptive.h"

#include <array>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "falling_card.h"
#include "kirchhoff_ellipsoid.h"
#include "samara/base/errors.h"
#include "samara/models/integrators/lie_group.h"
#include "samara/models/laws/registry.h"
#include "scalar_model.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

BodyMotion motion(const Trajectory& trajectory, Eigen::Index row) {
  const Eigen::VectorXd x = trajectory.states.row(row);
  return {{x[3], x[4], x[5], x[6]}, x.segment<3>(0), x.segment<3>(7), x.segment<3>(10)};
}

/// x' = -x^2, x(0) = 1: x = 1/(1 + t).
}  // namespace

TEST_CASE("the adaptive method conserves energy and both impulses of the Kirchhoff check problem") {
  const ParametricModel body(find_model("immersed_body"), ellipsoid_421_values(), {});
  const std::array times = {0.0, 1.0, 10.0};
  const Trajectory trajectory = integrate_adaptive(body, {}, times);
  REQUIRE(trajectory.is_usable());
  const LieGroupIntegrator invariants(ellipsoid_421_inertia());
  const BodyMotion start = motion(trajectory, 0);
  for (Eigen::Index row = 1; row < 3; ++row) {
    const BodyMotion now = motion(trajectory, row);
    const Eigen::Vector3d P = invariants.world_impulse(start);
    const Eigen::Vector3d L = invariants.world_angular_impulse(start);
    CHECK_THAT(invariants.kinetic_energy(now), WithinRel(invariants.kinetic_energy(start), 1e-10));
    CHECK((invariants.world_impulse(now) - P).norm() < 1e-10 * P.norm());
    CHECK((invariants.world_angular_impulse(now) - L).norm() < 1e-10 * L.norm());
  }
  const Eigen::Vector3d u(-1.00957568, 1.30092497, 0.81928126);
  const Eigen::Vector3d w(-0.61312995, 1.23152154, 0.70891937);
  CHECK((motion(trajectory, 2).v_WB_B - u).lpNorm<Eigen::Infinity>() < 6e-9);  // digits of the sheet
  CHECK((motion(trajectory, 2).w_WB_B - w).lpNorm<Eigen::Infinity>() < 6e-9);
}

TEST_CASE("the adaptive method takes steps of order seven to eight") {
  const ParametricModel body(find_model("immersed_body"), ellipsoid_421_values(), {});
  const auto steps = [&](double tolerance) {
    const Trajectory trajectory =
        integrate_adaptive(body, {}, std::array{10.0}, {.relative_tolerance = tolerance});
    return static_cast<double>(trajectory.steps);
  };
  // The estimate of the error of a step is of order h^8: steps grow as tolerance^(-1/8), but for the first
  // and the last ones.
  const double order = std::log(1e4) / std::log(steps(1e-13) / steps(1e-9));
  CHECK_THAT(order, WithinAbs(8.0, 1.0));
}

TEST_CASE("the adaptive method agrees with the reference integrator on the falling card") {
  const ParametricModel card = falling_card({"C_R", "a"});
  const std::array q = {1.21, 0.035};
  std::vector<double> times;
  for (int k = 0; k <= 60; ++k) times.push_back(0.005 * k);
  const Trajectory reference = integrate(card, q, times, {.relative_tolerance = 1e-12});
  const Trajectory trajectory = integrate_adaptive(card, q, times, {.relative_tolerance = 1e-11});
  REQUIRE(trajectory.is_usable());
  CHECK(trajectory.states.row(0) == reference.states.row(0));
  // The reference errs by 3e-9 itself (rk4_test), and more where the motion has grown apart, at 0.3 s.
  CHECK((trajectory.states - reference.states).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("the adaptive method ends on the times asked for, and the same call gives the same bits") {
  AdaptiveIntegrator integrator(hyperbola());
  const std::array times = {0.0, 0.1, 0.1, 0.100001, 3.0};
  const Trajectory first = integrator({}, times);
  REQUIRE(first.is_usable());
  for (Eigen::Index k = 0; k < 5; ++k) {
    CHECK_THAT(first.states(k, 0), WithinRel(1.0 / (1.0 + first.times[k]), 1e-11));
  }
  CHECK(first.states(0, 0) == 1.0);
  integrator({}, std::array{7.0});
  CHECK(integrator({}, times).states == first.states);
  CHECK(first.message == "reached t = 3 in " + std::to_string(first.steps) + " steps");
}

TEST_CASE("a solution that ends, or blows up, ends the adaptive method with a status") {
  // x' = -sqrt(1 - t): f exists up to t = 1.
  const ParametricModel ends(
      scalar_model([](double t, double) { return -std::sqrt(1.0 - t); }, [](double, double) { return 0.0; }),
      {}, {});
  const Trajectory beyond = integrate_adaptive(ends, {}, std::array{0.5, 2.0});
  CHECK(beyond.status == IntegrateStatus::not_finite);
  CHECK(beyond.reached <= 1.0);
  CHECK(std::isfinite(beyond.states(0, 0)));
  CHECK(std::isnan(beyond.states(1, 0)));

  const ParametricModel blows(
      scalar_model([](double, double x) { return x * x; }, [](double, double x) { return 2.0 * x; }),
      {{"x(0)", 1.0}}, {});
  const Trajectory blown = integrate_adaptive(blows, {}, std::array{0.5, 2.0}, {.max_steps = 100000});
  CHECK_FALSE(blown.is_usable());
  CHECK_THAT(blown.reached, WithinAbs(1.0, 1e-6));

  const Trajectory short_of_steps = integrate_adaptive(hyperbola(), {}, std::array{20.0}, {.max_steps = 3});
  CHECK(short_of_steps.status == IntegrateStatus::too_many_steps);
}

TEST_CASE("the adaptive method refuses options, points and times without meaning") {
  CHECK_THROWS_WITH(AdaptiveIntegrator(hyperbola(), {.relative_tolerance = 0.0}),
                    "relative_tolerance is 0; a value between 0 and 1 was expected");
  CHECK_THROWS_WITH(AdaptiveIntegrator(hyperbola(), {.max_steps = 0}),
                    "max_steps is 0; 1 or more was expected");
  CHECK_THROWS_AS(integrate_adaptive(hyperbola(), std::array{1.0}, std::array{1.0}), samara::ArgumentError);
  CHECK_THROWS_AS(integrate_adaptive(hyperbola(), {}, std::array{2.0, 1.0}), samara::ArgumentError);
}
