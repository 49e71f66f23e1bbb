#include "samara/pgd/nonlinear/strategy_trial.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <catch2/catch.hpp>

#include "../slab_systems.h"
#include "samara/pgd/evolution/polynomial_system.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

constexpr double kGravity = 9.81;
constexpr double kDrag = 1.23 * 0.5 / (2.0 * 0.1);  // of C_D = 1, in 1/m

/// (6.20) as printed, u' = k C_D u^2 - g, right for u <= 0.
PolynomialSystem quadratic_drag() {
  return {1, 1, {{0, kDrag, {1}, {2}}, {0, -kGravity, {}, {}}}};
}

EvolutionProblem drag_problem(const EvolutionSystem& system, double end, int slabs) {
  return {&system,
          Axis::radau({"t", "s", AxisRole::time}, 0.0, end, slabs, 9),
          {Axis::chebyshev({"C_D"}, 0.5, 2.0, 14)},
          {{"u", "m/s"}},
          {2.5},
          {{0.0, -1}}};
}

/// Largest error over the scale at random points.
double drag_error(const StrategyTrial& result, double end) {
  Random random(3);
  double largest = 0.0;
  for (int i = 0; i < 300; ++i) {
    const std::vector<double> x = {end * random.uniform(), 0.5 + 1.5 * random.uniform()};
    const double terminal = std::sqrt(kGravity / (kDrag * x[1]));
    const double exact = -terminal * std::tanh(kGravity * x[0] / terminal);
    largest = std::max(largest, std::abs(result.value_at(x)[0] - exact) / 2.5);
  }
  return largest;
}

EvolutionProblem pendulum_problem(const EvolutionSystem& system, double amplitude, double end, int slabs) {
  return {&system,
          Axis::radau({"t"}, 0.0, end, slabs, 8),
          {Axis::chebyshev({"c"}, 0.1, 0.4, 9), Axis::chebyshev({"k"}, 0.8, 1.2, 9)},
          {{"theta"}, {"omega"}},
          {1.0, 1.0},
          {{amplitude, -1}, {0.0, -1}}};
}

double pendulum_error(const StrategyTrial& result, const slab_systems::System& system, double amplitude,
                      double end) {
  Random random(4);
  double largest = 0.0;
  for (int i = 0; i < 40; ++i) {
    const double t = end * random.uniform();
    const Eigen::Vector2d q(0.1 + 0.3 * random.uniform(), 0.8 + 0.4 * random.uniform());
    const Eigen::VectorXd exact = system.exact(Eigen::Vector2d(amplitude, 0.0), q, t, 2e-3);
    largest = std::max(largest,
                       (result.value_at(std::vector<double>{t, q[0], q[1]}) - exact).cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace

TEST_CASE("products and cross interpolation give incremental linearisation the same solution") {
  const PolynomialSystem system = quadratic_drag();
  const EvolutionProblem problem = drag_problem(system, 0.4, 4);
  const auto products = incremental_strategy();
  const auto cross = cross_strategy({.newton = false});
  for (Strategy* strategy : {products.get(), cross.get()}) {
    const StrategyTrial result = try_strategy(problem, *strategy, {.tolerance = 1e-7});
    CAPTURE(strategy->name(), result.message);
    CHECK(result.status == samara::Termination::converged);
    CHECK(drag_error(result, 0.4) <= 1e-6);
  }
}

TEST_CASE("the asymptotic numerical method meets 1e-6 on quadratic drag, its terms falling geometrically") {
  const PolynomialSystem system = quadratic_drag();
  const auto strategy = asymptotic_strategy();
  const StrategyTrial result = try_strategy(drag_problem(system, 0.4, 4), *strategy, {.tolerance = 1e-7});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::converged);
  CHECK(drag_error(result, 0.4) <= 1e-6);
  CHECK(result.largest_contraction() < 0.9);
}

TEST_CASE("a series whose radius of convergence is below one is reported as such") {
  const PolynomialSystem system = quadratic_drag();
  const auto strategy = asymptotic_strategy();
  const StrategyTrial result = try_strategy(drag_problem(system, 2.0, 1), *strategy, {.tolerance = 1e-6});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::diverged);
  CHECK_THAT(result.message, Contains("radius of convergence"));
  CHECK(result.pieces.empty());
}

TEST_CASE("incremental linearisation loses contraction on a slab that is too long, and says where") {
  const PolynomialSystem system = quadratic_drag();
  const auto strategy = incremental_strategy();
  const StrategyTrial result = try_strategy(drag_problem(system, 2.0, 1), *strategy, {.tolerance = 1e-6});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::diverged);
  CHECK_THAT(result.message, Contains("between t = 0 and 2"));
}

TEST_CASE("polynomial linearisation about rest errs by the power of the amplitude above its order") {
  const slab_systems::System system = slab_systems::pendulum();
  // About rest sin(x) has no quadratic term: both orders err by the cube of the amplitude.
  for (const int order : {1, 2}) {
    std::vector<double> errors;
    for (const double amplitude : {0.2, 0.1}) {
      const auto strategy = polynomial_strategy({.order = order, .state = Eigen::Vector2d::Zero()});
      const StrategyTrial result =
          try_strategy(pendulum_problem(system, amplitude, 2.0, 4), *strategy, {.tolerance = 1e-8});
      CAPTURE(order, amplitude, result.message);
      REQUIRE(result.status == samara::Termination::converged);
      errors.push_back(pendulum_error(result, system, amplitude, 2.0));
      // The defect does not hide that these are other equations.
      CHECK(result.largest_defect() > 1e-6);
    }
    CHECK(std::log2(errors[0] / errors[1]) == Approx(3.0).margin(0.2));
  }
}

TEST_CASE("empirical interpolation and Newton with crosses meet 1e-6 on a large swing") {
  const slab_systems::System system = slab_systems::pendulum();
  const auto newton = cross_strategy();
  const auto empirical = empirical_strategy();
  for (Strategy* strategy : {newton.get(), empirical.get()}) {
    const StrategyTrial result =
        try_strategy(pendulum_problem(system, 1.5, 2.0, 4), *strategy, {.tolerance = 1e-7});
    CAPTURE(strategy->name(), result.message);
    CHECK(result.status == samara::Termination::converged);
    CHECK(pendulum_error(result, system, 1.5, 2.0) <= 1e-6);
    CHECK(result.rhs_evaluations > 0);
  }
}

TEST_CASE("piecewise-linear approximation errs by about a per cent, less with more points") {
  const slab_systems::System system = slab_systems::pendulum();
  std::vector<double> errors;
  for (const int points : {10, 60}) {
    const auto strategy = piecewise_linear_strategy({.points = points});
    const StrategyTrial result =
        try_strategy(pendulum_problem(system, 1.5, 2.0, 4), *strategy, {.tolerance = 1e-4});
    CAPTURE(points, result.message);
    REQUIRE(result.status == samara::Termination::converged);
    errors.push_back(pendulum_error(result, system, 1.5, 2.0));
  }
  CHECK(errors[0] < 0.1);
  CHECK(errors[1] < 0.5 * errors[0]);
}
