#include <catch2/catch.hpp>

#include "evolution_systems.h"

using namespace samara::pgd;
using namespace evolution_systems;
using Catch::Matchers::Contains;

TEST_CASE("the parametric line (6.18) is one product, to 1e-12") {
  const TestSystem system = constant_rate();
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    for (const double start : {0.0, 0.3}) {
      const EvolutionProblem problem{&system,
                                     Axis::radau({"t", "s", AxisRole::time}, 0.0, 10.0, 4, 3),
                                     {Axis::chebyshev({"k"}, 1.0, 10.0, 60)},
                                     {{"u"}},
                                     {90.0},
                                     {{start, -1}}};
      const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-13, .projection = projection});
      CAPTURE(report(result));
      CHECK(result.status == samara::Termination::converged);
      // The initial value is a term of its own.
      CHECK(result.field.rank() == (start == 0.0 ? 1 : 2));
      double error = 0.0;
      Random random(1);
      for (int i = 0; i < 1000; ++i) {
        const std::vector<double> x = {10.0 * random.uniform(), 1.0 + 9.0 * random.uniform()};
        // 60 Chebyshev nodes resolve 1 / k, whose pole lies 1.22 half lengths from the centre, to 1.9^-60.
        error = std::max(error, std::abs(result.field(x)[0] - start - (10.0 / x[1] - 1.0) * x[0]));
      }
      CHECK(error < 1e-12 * 90.0);  // 90 = largest |u|
    }
  }
}

TEST_CASE("quadratic drag (6.20) agrees with the exact solution to 1e-8") {
  const Fall fall;
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    const EvolutionResult result = solve_evolution(
        fall.problem(10, 9, 20), {.tolerance = 1e-10, .projection = projection, .linear_tolerance = 0.03});
    CAPTURE(report(result), Fall::error(result.field));
    CHECK(result.status == samara::Termination::converged);
    CHECK(result.residual <= 1e-10);
    CHECK(Fall::error(result.field) <= 1e-8);
    CHECK(result.history.size() <= 12);
    CHECK(result.field.rank() <= 14);
  }
}

TEST_CASE("a linear oscillator with its initial values as axes is exact to 1e-8") {
  const Oscillator oscillator;
  const EvolutionResult result = solve_evolution(oscillator.problem(), {.tolerance = 1e-10});
  double error = 0.0;
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const std::vector<double> x = {random.uniform(), 1.0 + random.uniform(), -1.0 + 3.0 * random.uniform(),
                                   -1.0 + 2.0 * random.uniform()};
    const double c = std::cos(x[1] * x[0]);
    const double s = std::sin(x[1] * x[0]);
    const Vector u = result.field(x);
    error = std::max(
        {error, std::abs(u[0] - x[2] * c - x[3] / x[1] * s), std::abs(u[1] + x[1] * x[2] * s - x[3] * c)});
  }
  CAPTURE(report(result), error);
  CHECK(result.status == samara::Termination::converged);
  CHECK(error <= 1e-8);
}

TEST_CASE("the solution converges with the order of the time elements") {
  // u' = -q u. s Radau points: order s + 1 between the nodes, 2 s - 1 at the ends of the elements.
  const TestSystem system = decay();
  for (const int s : {1, 2, 3}) {
    const auto errors = [&](int elements) {
      const EvolutionProblem problem = decay_problem(system, Axis::radau({"t", "s"}, 0.0, 1.0, elements, s));
      const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-12});
      REQUIRE(result.status == samara::Termination::converged);
      Random random(6);
      double between = 0.0;
      for (int i = 0; i < 1000; ++i) {
        const std::vector<double> x = {random.uniform(), 1.0 + random.uniform()};
        between = std::max(between, std::abs(result.field(x)[0] - std::exp(-x[1] * x[0])));
      }
      return std::pair(between, std::abs(result.field(std::vector<double>{1.0, 2.0})[0] - std::exp(-2.0)));
    };
    const auto coarse = errors(6);
    const auto fine = errors(12);
    CAPTURE(s, coarse.first, fine.first, coarse.second, fine.second);
    // One point per element is the implicit Euler method: its error of first order at the ends is everywhere.
    CHECK(std::log2(coarse.first / fine.first) > (s == 1 ? 1 : s + 1) - 0.2);
    CHECK(std::log2(coarse.second / fine.second) > 2 * s - 1 - 0.2);
  }
}

TEST_CASE("every kind of axis serves for time and for parameters") {
  const TestSystem system = decay();
  const auto error = [&](const Axis& time, const Axis& parameter) {
    EvolutionProblem problem = decay_problem(system, time);
    problem.parameters = {parameter};
    const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-10});
    REQUIRE(result.status == samara::Termination::converged);
    Random random(7);
    double largest = 0.0;
    for (int i = 0; i < 500; ++i) {
      const std::vector<double> x = {random.uniform(), 1.0 + random.uniform()};
      largest = std::max(largest, std::abs(result.field(x)[0] - std::exp(-x[1] * x[0])));
    }
    return largest;
  };
  const Axis smooth = Axis::chebyshev({"q"}, 1.0, 2.0, 12);
  CHECK(error(Axis::chebyshev({"t", "s"}, 0.0, 1.0, 14), smooth) < 1e-9);
  CHECK(error(Axis::radau({"t", "s"}, 0.0, 1.0, 5, 7), Axis::radau({"q"}, 1.0, 2.0, 2, 7)) < 1e-9);
  // Linear elements: in time the implicit Euler method, h / 2 max |u''| e..; in q h^2 / 8 max |d2u/dq2|.
  CHECK(error(Axis::p1({"t", "s"}, 0.0, 1.0, 101), smooth) < 0.5 * 0.01 * 4.0);
  CHECK(error(Axis::radau({"t", "s"}, 0.0, 1.0, 5, 7), Axis::p1({"q"}, 1.0, 2.0, 21)) <
        0.05 * 0.05 / 8.0 * 0.54);
}

TEST_CASE("time enters in its own unit and from where the axis starts") {
  // u' = q cos t from u(1) = 0: u = q (sin t - sin 1), one product.
  const TestSystem system(
      1, [](double t, const Vector&, const Vector& q) { return one(q[0] * std::cos(t)); },
      [](double, const Vector&, const Vector&) { return one_by_one(0.0); });
  const EvolutionProblem problem{&system,
                                 Axis::radau({"t", "s", AxisRole::time}, 1.0, 4.0, 6, 7),
                                 {Axis::chebyshev({"q"}, -1.0, 2.0, 4)},
                                 {{"u"}},
                                 {0.1},
                                 {{0.0, -1}}};
  const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-9});
  REQUIRE(result.status == samara::Termination::converged);
  CHECK(result.field.rank() == 1);
  for (const double t : {1.0, 1.3, 2.5, 4.0}) {
    CHECK(result.field(std::vector<double>{t, 1.7})[0] ==
          Approx(1.7 * (std::sin(t) - std::sin(1.0))).margin(1e-9));
  }
}

TEST_CASE("initial values are met exactly") {
  const Oscillator oscillator;
  const EvolutionResult result = solve_evolution(oscillator.problem(), {.tolerance = 1e-6});
  for (const double x0 : {-1.0, 0.3, 2.0}) {
    const Vector u = result.field(std::vector<double>{0.0, 1.4, x0, -0.7});
    CHECK(u[0] == Approx(x0).epsilon(1e-14));
    CHECK(u[1] == Approx(-0.7).epsilon(1e-14));
  }
}

TEST_CASE("a body that turns from rising to sinking agrees with Runge-Kutta to 1e-4") {
  const Sinking sinking;
  const EvolutionResult result = solve_evolution(sinking.problem(8, 30), {.tolerance = 1e-5});
  double error = 0.0;
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const std::vector<double> x = {0.5 * random.uniform(), 0.8 + 0.8 * random.uniform(),
                                   -0.3 + 0.9 * random.uniform()};
    const Eigen::Vector2d exact = Sinking::exact(x[0], x[1], x[2]);
    const Vector u = result.field(x);
    // In parts of the ranges, 0.9 m/s and 0.25 m.
    error = std::max({error, std::abs(u[0] - exact[0]) / 0.9, std::abs(u[1] - exact[1]) / 0.25});
  }
  CAPTURE(report(result), error);
  CHECK(result.status == samara::Termination::converged);
  CHECK(error < 1e-4);
}
