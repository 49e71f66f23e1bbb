#include "samara/models/integrators/integrate.h"

#include <array>
#include <cmath>
#include <thread>

#include <catch2/catch.hpp>

#include "accuracy.h"
#include "samara/base/errors.h"
#include "samara/models/laws/registry.h"
#include "scalar_model.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;

namespace {

ParametricModel coin() {
  return ParametricModel(find_model("vertical_fall"), {{"area", 4.714e-4}, {"thickness", 2.55e-3}},
                         {"C_D", "v(0)", "density"});
}

const std::vector<double> kCoinPoint = {1.15, -0.2, 6339.0};
const std::vector<double> kIntegrationTimes = {0.0, 0.1, 0.1, 0.25, 0.5};

/// x' = x^2 from x(0) = 1: x = 1/(1 - t), which is infinite at t = 1.
ParametricModel blow_up() {
  return ParametricModel(
      scalar_model([](double, double x) { return x * x; }, [](double, double x) { return 2.0 * x; }),
      {{"x(0)", 1.0}}, {});
}

/// x' = sqrt(1 - t), which is no real number after t = 1.
ParametricModel ends_at_one() {
  return ParametricModel(
      scalar_model([](double t, double) { return std::sqrt(1.0 - t); }, [](double, double) { return 0.0; }),
      {}, {});
}

bool same_bits(const Trajectory& a, const Trajectory& b) {
  return a.steps == b.steps && a.states == b.states && a.sensitivities == b.sensitivities;
}

}  // namespace

TEST_CASE("rows at t = 0 are the initial values exactly, and repeated times repeat rows") {
  const Trajectory trajectory =
      integrate(coin(), kCoinPoint, std::vector<double>{0.0, 0.0, 0.1, 0.1}, {}, true);
  REQUIRE(trajectory.is_usable());
  CHECK(trajectory.reached == 0.1);
  for (const Eigen::Index row : {0, 1}) {
    CHECK(trajectory.states(row, 0) == -0.2);
    CHECK(trajectory.states(row, 1) == 0.0);
    CHECK(trajectory.sensitivities[0].row(row) == Eigen::RowVector2d(0.0, 0.0));
    CHECK(trajectory.sensitivities[1].row(row) == Eigen::RowVector2d(1.0, 0.0));
  }
  CHECK(trajectory.states.row(2) == trajectory.states.row(3));
  CHECK(trajectory.sensitivities[2].row(2) == trajectory.sensitivities[2].row(3));
}

TEST_CASE("no times, or only zeros, need no step") {
  const Trajectory none = integrate(coin(), kCoinPoint, {});
  CHECK(none.is_usable());
  CHECK(none.states.rows() == 0);
  const Trajectory zeros = integrate(coin(), kCoinPoint, std::array{0.0, 0.0});
  CHECK(zeros.is_usable());
  CHECK(zeros.steps == 0);
  CHECK(zeros.rhs_evaluations == 0);
  CHECK(zeros.states(1, 0) == -0.2);
}

TEST_CASE("a trajectory tells what it took") {
  const Trajectory trajectory = integrate(coin(), kCoinPoint, kIntegrationTimes);
  CHECK(trajectory.steps > 10);
  CHECK(trajectory.rhs_evaluations >= trajectory.steps);
  CHECK(trajectory.message == "reached t = 0.5 in " + std::to_string(trajectory.steps) + " steps");
  CHECK(trajectory.sensitivities.empty());
}

TEST_CASE("the error falls in proportion to the tolerance") {
  const ParametricModel logistic(scalar_model([](double, double x) { return x * (1.0 - x); },
                                              [](double, double x) { return 1.0 - 2.0 * x; }),
                                 {{"x(0)", 0.1}}, {});
  const auto exact = [](double t) { return 1.0 / (1.0 + 9.0 * std::exp(-t)); };
  for (const bool stiff : {false, true}) {
    const auto error = [&](double tolerance) {
      const Trajectory trajectory = integrate(logistic, {}, std::array{2.0, 4.0, 6.0},
                                              {.relative_tolerance = tolerance, .stiff = stiff});
      REQUIRE(trajectory.is_usable());
      double largest = 0.0;
      for (Eigen::Index row = 0; row < 3; ++row) {
        largest = std::max(largest, std::abs(trajectory.states(row, 0) - exact(trajectory.times[row])));
      }
      // Growth amplifies early errors by at most x'(t)/x'(0) <= 0.25/0.09 < 3.
      CHECK(largest < 3.0 * promised(trajectory, tolerance, 1.0));
      return largest;
    };
    // Control of the error per step, not per unit time, at order m gives error ~ tolerance^(m/(m+1)): Adams
    // goes up to order 12, BDF to 5, which is 0.92 and 0.83; orders that are lower for a part of the way, and
    // change with the tolerance, take some of it.
    const double rate = std::log10(error(1e-5) / error(1e-10)) / 5.0;
    INFO("stiff " << stiff << ", rate " << rate);
    CHECK(rate > (stiff ? 0.6 : 0.75));
    CHECK(rate < 1.25);
  }
}

TEST_CASE("BDF takes far fewer steps than Adams on a stiff equation, to the same solution") {
  // x' = -L (x - cos t), x(0) = 0: a transient exp(-L t), then x = (L^2 cos t + L sin t)/(L^2 + 1).
  constexpr double L = 1e4;
  const ParametricModel model(scalar_model([](double t, double x) { return -L * (x - std::cos(t)); },
                                           [](double, double) { return -L; }),
                              {}, {});
  const double exact = (L * L * std::cos(1.0) + L * std::sin(1.0)) / (L * L + 1.0);
  const IntegrateOptions adams = {.relative_tolerance = 1e-8};
  const IntegrateOptions bdf = {.relative_tolerance = 1e-8, .stiff = true};
  const Trajectory slow = integrate(model, {}, std::array{1.0}, adams);
  const Trajectory fast = integrate(model, {}, std::array{1.0}, bdf);
  // Errors are forgotten within 1/L: only those of the last few steps are left.
  CHECK_THAT(slow.states(0, 0), WithinAbs(exact, 1e-6));
  CHECK_THAT(fast.states(0, 0), WithinAbs(exact, 1e-6));
  // Adams must keep L h of order one: about L steps.
  CHECK(slow.steps > 2000);
  CHECK(fast.steps < 400);
}

TEST_CASE("too few steps are a status, and the rows reached are kept") {
  const Trajectory whole = integrate(coin(), kCoinPoint, kIntegrationTimes, {}, true);
  const Trajectory part =
      integrate(coin(), kCoinPoint, kIntegrationTimes, {.max_steps = whole.steps - 1}, true);
  CHECK(part.status == IntegrateStatus::too_many_steps);
  CHECK_FALSE(part.is_usable());
  CHECK(part.steps == whole.steps - 1);
  CHECK(part.reached < 0.5);
  CHECK(part.reached > 0.25);
  CHECK(part.states.topRows(4) == whole.states.topRows(4));
  CHECK(std::isnan(part.states(4, 0)));
  CHECK(std::isnan(part.sensitivities[1](4, 1)));
  CHECK_THAT(part.message,
             Catch::StartsWith("stopped at t = 0.") &&
                 Catch::EndsWith("of 0.5 after " + std::to_string(part.steps) +
                                 " steps: that is all the steps allowed; a shorter time takes fewer, and so "
                                 "does BDF, of single trajectories, where equations are stiff"));
  // The limit is on the trajectory, not on the way between two times.
  CHECK(integrate(coin(), kCoinPoint, kIntegrationTimes, {.max_steps = whole.steps}, true).is_usable());
}

TEST_CASE("a solution that blows up ends with a status, near the blow-up") {
  for (const bool stiff : {false, true}) {
    const Trajectory trajectory =
        integrate(blow_up(), {}, std::array{0.5, 0.9, 2.0}, {.relative_tolerance = 1e-8, .stiff = stiff});
    CHECK(trajectory.status != IntegrateStatus::done);
    CHECK(trajectory.status != IntegrateStatus::failed);
    // The pole of the computed solution is where rounding and tolerance leave it.
    CHECK_THAT(trajectory.reached, WithinAbs(1.0, 1e-5));
    // An error d at t grows by (x(0.9)/x(t))^2 <= 100 until 0.9.
    CHECK_THAT(trajectory.states(1, 0), WithinAbs(10.0, 100.0 * promised(trajectory, 1e-8, 10.0)));
    CHECK(std::isnan(trajectory.states(2, 0)));
    CHECK_THAT(trajectory.message, Catch::StartsWith("stopped at t = ") && Catch::Contains(" of 2 after "));
  }
}

TEST_CASE("a right-hand side that ceases to exist ends with a status, at that time") {
  const Trajectory beyond = integrate(ends_at_one(), {}, std::array{0.5, 2.0});
  CHECK(beyond.status == IntegrateStatus::not_finite);
  CHECK(beyond.reached <= 1.0);
  CHECK(beyond.reached > 0.9);
  CHECK_THAT(beyond.message, Catch::Contains("the right-hand side is not finite (the rate of \""));
  CHECK_THAT(beyond.states(0, 0),
             WithinAbs(2.0 / 3.0 * (1.0 - std::pow(0.5, 1.5)), promised(beyond, 1e-10, 1.0)));
}

TEST_CASE("the right-hand side is never asked for beyond the last time") {
  double latest = 0.0;
  const ParametricModel model(scalar_model(
                                  [&latest](double t, double x) {
                                    latest = std::max(latest, t);
                                    return -x;
                                  },
                                  [](double, double) { return -1.0; }),
                              {{"x(0)", 1.0}}, {});
  CHECK(integrate(model, {}, std::array{0.3, 1.0}).is_usable());
  CHECK(latest <= 1.0);
  CHECK(latest > 0.99);
}

TEST_CASE("a right-hand side that is not finite at the start is a status too") {
  const ParametricModel model(
      scalar_model([](double, double x) { return 1.0 / x; }, [](double, double x) { return -1.0 / (x * x); }),
      {}, {});
  const Trajectory trajectory = integrate(model, {}, std::array{0.0, 1.0});
  CHECK(trajectory.status == IntegrateStatus::not_finite);
  CHECK(trajectory.reached == 0.0);
  CHECK(trajectory.states(0, 0) == 0.0);
}

TEST_CASE("what a model throws passes through, and the integrator is fit for use afterwards") {
  bool broken = true;
  const ParametricModel model(scalar_model(
                                  [&broken](double t, double x) {
                                    if (broken && t > 0.5) throw std::runtime_error("broken");
                                    return -x;
                                  },
                                  [](double, double) { return -1.0; }),
                              {{"x(0)", 1.0}}, {});
  Integrator integrator(model, {}, false);
  CHECK_THROWS_WITH(integrator({}, std::array{1.0}), "broken");
  broken = false;
  const Trajectory after = integrator({}, std::array{1.0});
  CHECK(same_bits(after, integrate(model, {}, std::array{1.0})));
}

TEST_CASE("an integrator used again gives the same bits as a fresh one") {
  const std::vector<double> other = {0.4, 0.9, 1500.0};
  const std::vector<double> other_times = {0.7};
  for (const bool stiff : {false, true}) {
    for (const bool with_sensitivities : {false, true}) {
      const IntegrateOptions options = {.stiff = stiff};
      const Trajectory fresh = integrate(coin(), kCoinPoint, kIntegrationTimes, options, with_sensitivities);
      Integrator integrator(coin(), options, with_sensitivities);
      CHECK(same_bits(integrator(kCoinPoint, kIntegrationTimes), fresh));
      CHECK(integrator(other, other_times).is_usable());
      CHECK(same_bits(integrator(kCoinPoint, kIntegrationTimes), fresh));
    }
  }
}

TEST_CASE("an integrator that failed, or was moved, is fit for use") {
  for (const bool stiff : {false, true}) {
    const ParametricModel model(
        scalar_model([](double, double x) { return x * x; }, [](double, double x) { return 2.0 * x; }), {},
        {"x(0)"});
    const IntegrateOptions options = {.stiff = stiff};
    Integrator integrator(model, options, true);
    CHECK_FALSE(integrator(std::array{1.0}, std::array{2.0}).is_usable());
    Integrator moved = std::move(integrator);
    const Trajectory after = moved(std::array{-1.0}, std::array{2.0});
    CHECK(same_bits(after, integrate(model, std::array{-1.0}, std::array{2.0}, options, true)));
  }
}

TEST_CASE("two threads with an integrator each give the results of one") {
  const ParametricModel model = coin();
  const auto run = [&model] {
    Integrator integrator(model, {}, true);
    std::vector<Trajectory> results;
    for (int k = 0; k < 40; ++k) {
      results.push_back(
          integrator(std::array{0.5 + 0.05 * k, 0.01 * k, 2000.0 + 50.0 * k}, kIntegrationTimes));
    }
    return results;
  };
  const std::vector<Trajectory> alone = run();
  std::array<std::vector<Trajectory>, 2> together;
  {
    std::jthread first([&] { together[0] = run(); });
    std::jthread second([&] { together[1] = run(); });
  }
  for (const auto& results : together) {
    REQUIRE(results.size() == alone.size());
    for (std::size_t k = 0; k < alone.size(); ++k) CHECK(same_bits(results[k], alone[k]));
  }
}

TEST_CASE("the integrator refuses times, points and options without meaning") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Integrator integrator(coin(), {}, false);
  CHECK_THROWS_AS(integrator(kCoinPoint, std::array{-1.0}), samara::ArgumentError);
  CHECK_THROWS_WITH(integrator(kCoinPoint, std::array{-1.0}), "times[0] is -1; 0 or more was expected");
  CHECK_THROWS_WITH(integrator(kCoinPoint, std::array{0.5, 0.25}),
                    "times[1] is 0.25; 0.5 (the time before it) or more was expected");
  CHECK_THROWS_WITH(integrator(kCoinPoint, std::array{0.5, nan}),
                    "times[1] is nan; a finite number was expected");
  CHECK_THROWS_WITH(integrator(std::array{1.0, 0.0, nan}, kIntegrationTimes),
                    "\"density\" is nan; a finite number was expected");
  CHECK_THROWS_WITH(Integrator(coin(), {.relative_tolerance = 0.0}, false),
                    "relative_tolerance is 0; a value between 0 and 1 was expected");
  CHECK_THROWS_WITH(Integrator(coin(), {.max_steps = 0}, false), "max_steps is 0; 1 or more was expected");
}
