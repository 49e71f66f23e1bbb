#include "samara/models/integrators/rk4.h"

#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "falling_card.h"
#include "samara/base/errors.h"
#include "samara/models/laws/registry.h"
#include "scalar_model.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// x' = -x^2, x(0) = 1: x = 1/(1 + t).
double hyperbola_error(double step) {
  return std::abs(integrate_rk4(hyperbola(), {}, std::array{2.0}, {.step = step}).states(0, 0) - 1.0 / 3.0);
}

}  // namespace

TEST_CASE("the fixed-step Runge-Kutta method has order four") {
  // Where the fifth order is still felt, the observed order is off by about h.
  const double order = std::log2(hyperbola_error(0.1) / hyperbola_error(0.05));
  CHECK_THAT(order, WithinAbs(4.0, 0.15));
}

TEST_CASE("the fixed-step Runge-Kutta method has order four on the falling card") {
  const ParametricModel card = falling_card({});
  const std::array times = {0.2};
  const Trajectory reference = integrate(card, {}, times, {.relative_tolerance = 1e-12});
  const auto error = [&](double step) {
    return (integrate_rk4(card, {}, times, {.step = step}).states - reference.states).norm();
  };
  // The errors are about 4e-7 and 3e-8, that of the reference about 3e-9: a tenth of the smaller one, 0.15 of
  // the order.
  CHECK_THAT(std::log2(error(1e-3) / error(5e-4)), WithinAbs(4.0, 0.3));
}

TEST_CASE("the errors of fixed steps on the falling card are those of the model sheet, section 4.2") {
  // The card of the reference state: damping by each axis alone, the chord along the velocity,
  // smoothed at 1e-9. Errors of the place.
  std::map<std::string, double> values = card_values();
  values["speed_floor"] = values["rate_floor"] = 1e-9;
  values["damping_isotropy"] = 0.0;
  values["velocity_chord"] = 1.0;
  const ParametricModel card(find_model("immersed_body"), values, {});
  const std::array times = {0.3};
  const auto place = [&](double step) {
    return Eigen::Vector3d(integrate_rk4(card, {}, times, {.step = step}).states.row(0).head<3>());
  };
  const Eigen::Vector3d exact = place(5e-5);
  const auto error = [&](double step) { return (place(step) - exact).norm(); };
  for (const auto& [step, stated] : {std::pair(4e-3, 1e-5), std::pair(2e-3, 3e-7), std::pair(1e-3, 1.6e-8)}) {
    INFO("step " << step);
    const double ratio = error(step) / stated;
    CHECK(ratio < 3.0);
    CHECK(ratio > 1.0 / 3.0);
  }
}

TEST_CASE("fixed steps end on the times asked for") {
  const std::array times = {0.0, 0.25, 0.25, 0.3, 1.0};
  const Trajectory trajectory = integrate_rk4(hyperbola(), {}, times, {.step = 0.1});
  REQUIRE(trajectory.is_usable());
  CHECK(trajectory.steps == 3 + 0 + 1 + 7);
  CHECK(trajectory.states(0, 0) == 1.0);
  CHECK(trajectory.states(1, 0) == trajectory.states(2, 0));
  for (Eigen::Index k = 0; k < 5; ++k) {
    CHECK_THAT(trajectory.states(k, 0), WithinAbs(1.0 / (1.0 + trajectory.times[k]), 1e-6));
  }
  CHECK(trajectory.message == "reached t = 1 in 11 steps");
}

TEST_CASE("the kernels of a law take the steps of its right-hand side") {
  const ParametricModel card = falling_card({"C_R", "ux(0)"});
  const ParametricModel plain(std::make_shared<PlainModel>(card.shared_model()), card.fixed(),
                              {"C_R", "ux(0)"});
  const std::array q = {1.3, 0.07};
  const std::array times = {0.1, 0.3};
  const Trajectory by_kernel = integrate_rk4(card, q, times);
  const Trajectory by_rhs = integrate_rk4(plain, q, times);
  // 300 steps, each with a few roundings, of states that grow by a factor of ten or so.
  CHECK((by_kernel.states - by_rhs.states).cwiseAbs().maxCoeff() <
        1e-12 * by_rhs.states.cwiseAbs().maxCoeff());
}

TEST_CASE("fixed steps beyond the end of a solution end with a status") {
  const ParametricModel model(
      scalar_model([](double, double x) { return x * x; }, [](double, double x) { return 2.0 * x; }),
      {{"x(0)", 1.0}}, {});
  const Trajectory trajectory = integrate_rk4(model, {}, std::array{0.5, 2.0}, {.step = 0.01});
  CHECK(trajectory.status == IntegrateStatus::not_finite);
  CHECK(trajectory.reached == 0.5);
  CHECK_THAT(trajectory.states(0, 0), WithinRel(2.0, 1e-6));
  CHECK(std::isnan(trajectory.states(1, 0)));
  CHECK_THAT(trajectory.message, Catch::StartsWith("stopped at t = 0.5 of 2 after 200 steps: "));
}

TEST_CASE("fixed steps stop where more than allowed would be needed") {
  const Trajectory trajectory =
      integrate_rk4(hyperbola(), {}, std::array{0.5, 2.0}, {.step = 0.01, .max_steps = 100});
  CHECK(trajectory.status == IntegrateStatus::too_many_steps);
  CHECK(trajectory.reached == 0.5);
}

TEST_CASE("the fixed-step integrator refuses steps, points and times without meaning") {
  CHECK_THROWS_WITH(Rk4Integrator(hyperbola(), {.step = 0.0}),
                    "step is 0; a positive finite number was expected");
  CHECK_THROWS_WITH(Rk4Integrator(hyperbola(), {.step = std::nan("")}),
                    "step is nan; a positive finite number was expected");
  CHECK_THROWS_WITH(Rk4Integrator(hyperbola(), {.max_steps = 0}), "max_steps is 0; 1 or more was expected");
  CHECK_THROWS_AS(integrate_rk4(hyperbola(), std::array{1.0}, std::array{1.0}), samara::ArgumentError);
  CHECK_THROWS_AS(integrate_rk4(hyperbola(), {}, std::array{-1.0}), samara::ArgumentError);
}

TEST_CASE("steps beyond count stop the fixed-step integrator before the first") {
  for (const double step : {1e-20, 1e-300}) {
    const Trajectory trajectory = integrate_rk4(hyperbola(), {}, std::array{5.0}, {.step = step});
    CHECK(trajectory.status == IntegrateStatus::too_many_steps);
    CHECK(trajectory.message ==
          "stopped at t = 0 of 5 after 0 steps: the next time takes more steps than allowed");
    CHECK(std::isnan(trajectory.states(0, 0)));
  }
}
