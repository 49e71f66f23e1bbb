#include <catch2/catch.hpp>

#include "evolution_systems.h"

using namespace samara::pgd;
using namespace evolution_systems;
using Catch::Matchers::Contains;

TEST_CASE("a solution that ends inside the box is never reported as converged") {
  const TestSystem system = explosion();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const EvolutionResult result =
        solve_evolution(explosion_problem(system, 0.5, 1.5), {.tolerance = 1e-6, .seed = seed});
    CAPTURE(report(result));
    CHECK(result.status == samara::Termination::diverged);
    CHECK(result.residual > 1e-6);
    CHECK_THAT(result.message, Contains("may not exist on the whole box"));
  }
  // Nor on axes so coarse that the equations of the collocation might have solutions of their own, nor where
  // only a corner of the box is concerned.
  for (const double upper : {1.02, 1.1, 3.0}) {
    for (const auto& [elements, points] : {std::pair{1, 2}, {1, 3}, {2, 3}, {4, 4}}) {
      EvolutionProblem problem = explosion_problem(system, 0.5, upper);
      problem.time = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, elements, points);
      const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-6});
      CAPTURE(upper, elements, points, report(result));
      CHECK(result.status != samara::Termination::converged);
      CHECK(result.residual > 1e-6);
    }
  }
}

TEST_CASE("close to where solutions end they are still found") {
  const TestSystem system = explosion();
  const EvolutionResult result = solve_evolution(explosion_problem(system, 0.5, 0.8), {.tolerance = 1e-7});
  CAPTURE(report(result));
  CHECK(result.status == samara::Termination::converged);
  // The pole lies at t = 1.25: 10 elements of 5 points resolve it to 1e-5.
  for (const double t : {0.3, 0.77, 1.0}) {
    CHECK(result.field(std::vector<double>{t, 0.79})[0] == Approx(1.0 / (1.0 / 0.79 - t)).epsilon(1e-5));
  }
}

TEST_CASE("where the right-hand side or its derivative is not finite is said in coordinates") {
  const auto root = [](double, const Vector&, const Vector& q) { return one(std::sqrt(q[0])); };
  const auto finite = [](double, const Vector&, const Vector&) { return one(1.0); };
  const auto no_state = [](double, const Vector&, const Vector&) { return one_by_one(0.0); };
  const auto bad_derivative = [](double, const Vector&, const Vector& q) {
    return one_by_one(std::log(q[0]));
  };
  for (const bool rate_is_bad : {true, false}) {
    const TestSystem system =
        rate_is_bad ? TestSystem(1, root, no_state) : TestSystem(1, finite, bad_derivative);
    const EvolutionProblem problem{&system,
                                   Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 2, 3),
                                   {Axis::chebyshev({"area", "m^2"}, -1.0, 1.0, 9)},
                                   {{"u"}},
                                   {1.0},
                                   {{0.0, -1}}};
    const EvolutionResult result = solve_evolution(problem);
    CHECK(result.status == samara::Termination::not_finite);
    CHECK_THAT(result.message,
               Contains(rate_is_bad ? "right-hand side is not finite" : "Jacobian is not finite"));
    CHECK_THAT(result.message, Contains("t = ") && Contains(" s, area = -") && Contains("m^2"));
  }
}

TEST_CASE("a solution that leaves the domain of its right-hand side is not reported as converged") {
  // u' = -1 - sqrt(u) from u(0) in [0.2, 1] reaches zero before t = 1.
  const TestSystem system(
      1, [](double, const Vector& x, const Vector&) { return one(-1.0 - std::sqrt(x[0])); },
      [](double, const Vector& x, const Vector&) { return one_by_one(-0.5 / std::sqrt(x[0])); });
  EvolutionProblem problem = explosion_problem(system, 0.2, 1.0);
  const EvolutionResult result = solve_evolution(problem);
  CAPTURE(report(result));
  CHECK(result.status != samara::Termination::converged);
  CHECK_THAT(result.message, Contains("not finite at t = ") && Contains("u(0) = 0."));
}

TEST_CASE("a rank that does not suffice is reported") {
  const Fall fall;
  const EvolutionResult result = solve_evolution(fall.problem(6, 5, 16), {.tolerance = 1e-8, .max_rank = 2});
  CAPTURE(report(result));
  CHECK(result.status != samara::Termination::converged);
  CHECK(Fall::error(result.field) > 1e-6);
}

TEST_CASE("a right-hand side that is approximated too coarsely is reported, however small the residual") {
  // u' = sin(9 t q) needs more than four products; the equations of its best four are solved exactly.
  const TestSystem system(
      1, [](double t, const Vector&, const Vector& q) { return one(std::sin(9.0 * t * q[0])); },
      [](double, const Vector&, const Vector&) { return one_by_one(0.0); });
  EvolutionProblem problem = decay_problem(system, Axis::radau({"t", "s"}, 0.0, 1.0, 4, 6));
  problem.parameters = {Axis::chebyshev({"q"}, 0.0, 1.0, 16)};
  const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-8, .max_rank = 4});
  CAPTURE(report(result));
  CHECK(result.residual <= 1e-8);
  CHECK(result.nonlinearity_error > 1e-8);
  CHECK(result.status == samara::Termination::stagnated);
  CHECK_THAT(result.message, Contains("f is approximated only to"));
  const EvolutionResult enough = solve_evolution(problem, {.tolerance = 1e-8});
  CHECK(enough.status == samara::Termination::converged);
  CHECK(enough.nonlinearity_error <= 1e-8);
}

TEST_CASE("a former solution saves iterations, also from coarser axes") {
  const Fall fall;
  const EvolutionOptions options{.tolerance = 1e-9};
  const EvolutionProblem fine = fall.problem(20, 7, 20);
  const EvolutionResult cold = solve_evolution(fine, options);
  REQUIRE(cold.status == samara::Termination::converged);
  const auto from = [&](const EvolutionProblem& coarse) {
    const EvolutionResult first = solve_evolution(coarse, {.tolerance = 1e-5});
    REQUIRE(first.status == samara::Termination::converged);
    EvolutionResult second = solve_evolution(fine, options, &first.field);
    CAPTURE(report(first), report(second));
    CHECK(second.status == samara::Termination::converged);
    CHECK(second.history.size() < cold.history.size());
    CHECK(second.history.front().residual < 0.1 * cold.history.front().residual);
    CHECK(second.rhs_evaluations < cold.rhs_evaluations);
    CHECK(Fall::error(second.field) <= 1e-8);
  };
  from(fine);
  from(fall.problem(8, 4, 9));
  // The solution itself, of a looser tolerance than asked for, needs no step.
  const EvolutionResult again = solve_evolution(fine, {.tolerance = 1e-8}, &cold.field);
  CHECK(again.status == samara::Termination::converged);
  CHECK(again.history.size() == 1);
}

TEST_CASE("a guess over other axes or outputs is refused") {
  const Fall fall;
  const EvolutionProblem problem = fall.problem(4, 4, 8);
  const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-3});
  EvolutionProblem other = problem;
  other.parameters = {Axis::chebyshev({"mass", "kg"}, 0.5, 2.0, 8)};
  CHECK_THROWS_WITH(solve_evolution(other, {}, &result.field), Contains("(t, C_D)") && Contains("(t, mass)"));
  other.parameters = {problem.parameters[0], Axis::chebyshev({"mass", "kg"}, 0.5, 2.0, 8)};
  CHECK_THROWS_AS(solve_evolution(other, {}, &result.field), samara::ArgumentError);
  const SeparatedField two(result.field.axes(), {{"u"}, {"v"}}, result.field.factors(),
                           result.field.weights().replicate(2, 1));
  CHECK_THROWS_AS(solve_evolution(problem, {}, &two), samara::ArgumentError);
}

TEST_CASE("the allowed iterations end the solve with what was reached") {
  const Fall fall;
  const EvolutionResult result =
      solve_evolution(fall.problem(6, 5, 16), {.tolerance = 1e-9, .max_iterations = 3});
  CHECK(result.status == samara::Termination::max_iterations);
  CHECK_THAT(result.message, Contains("after all 3 iterations"));
  CHECK(result.history.size() == 4);  // the last one only measures
  CHECK(result.residual == result.history.back().residual);
  CHECK(std::isfinite(result.field(std::vector<double>{0.5, 1.0})[0]));
}

TEST_CASE("progress is reported, also within an iteration, and may cancel at any time") {
  const Fall fall;
  const auto solved = [&](std::size_t calls, std::vector<double>& fractions) {
    EvolutionOptions options{.tolerance = 1e-6};
    options.progress = [&fractions, calls](const samara::Progress& progress) {
      CHECK(progress.stage == "Newton");
      fractions.push_back(progress.fraction);
      return fractions.size() < calls;
    };
    return solve_evolution(fall.problem(6, 5, 12), options);
  };
  std::vector<double> whole;
  const EvolutionResult result = solved(1'000'000, whole);
  REQUIRE(result.status == samara::Termination::converged);
  // Evaluations and terms of the linear problems lie between two iterations.
  CHECK(whole.size() > 5 * result.history.size());
  for (const double fraction : whole) CHECK((fraction >= 0.0 && fraction <= 1.0));
  for (std::size_t calls = 1; calls < whole.size(); ++calls) {
    std::vector<double> fractions;
    const EvolutionResult cancelled = solved(calls, fractions);
    CHECK(cancelled.status == samara::Termination::cancelled);
    CHECK_THAT(cancelled.message, Contains("cancelled"));
    CHECK(fractions.size() == calls);
    CHECK(std::isfinite(cancelled.residual));
  }
}

TEST_CASE("sums of more products than are allowed end the solve, with what they would have taken") {
  const Fall fall;
  const EvolutionResult result = solve_evolution(fall.problem(6, 5, 12), {.tolerance = 1e-6, .max_terms = 2});
  CHECK(result.status == samara::Termination::rank_limit);
  CHECK_THAT(result.message, Contains("takes more than the 2 products allowed, a train of ranks"));
}

TEST_CASE("f is evaluated only where it is asked for, and every evaluation is counted") {
  const TestSystem system = explosion();
  const EvolutionResult result = solve_evolution(explosion_problem(system, 0.1, 0.6), {.tolerance = 1e-8});
  REQUIRE(result.status == samara::Termination::converged);
  CHECK(result.grid_size == 10 * 5 * 20);
  const std::vector<long>& rhs = system.rhs_counts();
  const std::vector<long>& jacobian = system.jacobian_counts();
  // The last iteration only measures the residual.
  REQUIRE(rhs.size() == result.history.size());
  REQUIRE(jacobian.size() == rhs.size() - 1);
  long all_rhs = 0;
  long all_jacobian = 0;
  for (std::size_t i = 0; i < rhs.size(); ++i) {
    const long j = i < jacobian.size() ? jacobian[i] : 0;
    CHECK(result.history[i].evaluations == rhs[i] + j);
    CHECK(result.history[i].step == 1.0);
    CHECK(static_cast<double>(rhs[i]) <= result.grid_size);
    CHECK(static_cast<double>(j) <= result.grid_size);
    all_rhs += rhs[i];
    all_jacobian += j;
  }
  CHECK(result.rhs_evaluations == all_rhs);
  CHECK(result.jacobian_evaluations == all_jacobian);
}

TEST_CASE("with more parameters the share of the grid that is evaluated falls") {
  // A body against drag with four parameters: 60 000 entries and more.
  const TestSystem system(
      1,
      [](double, const Vector& x, const Vector& q) {
        return one(-q[0] * q[1] * std::sqrt(x[0] * x[0] + 0.01) * x[0] / q[2] - q[3]);
      },
      [](double, const Vector& x, const Vector& q) {
        const double root = std::sqrt(x[0] * x[0] + 0.01);
        return one_by_one(-q[0] * q[1] / q[2] * (root + x[0] * x[0] / root));
      });
  const EvolutionProblem problem{
      &system,
      Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 3, 5),
      {Axis::chebyshev({"C_D"}, 0.5, 1.0, 8), Axis::chebyshev({"A", "m^2"}, 0.5, 1.0, 8),
       Axis::chebyshev({"m", "kg"}, 1.0, 1.5, 8), Axis::chebyshev({"g", "m/s^2"}, 0.8, 1.0, 8)},
      {{"u", "m/s"}},
      {1.0},
      {{0.0, -1}}};
  const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-5});
  CAPTURE(report(result));
  CHECK(result.status == samara::Termination::converged);
  for (const EvolutionRecord& record : result.history) {
    CHECK(static_cast<double>(record.evaluations) < 0.1 * result.grid_size);
  }
}

TEST_CASE("the same seed gives the same field to the last bit") {
  const Fall fall;
  const auto solve = [&](std::uint64_t seed) {
    return solve_evolution(fall.problem(6, 5, 16), {.tolerance = 1e-7, .seed = seed});
  };
  const EvolutionResult a = solve(3);
  const EvolutionResult b = solve(3);
  REQUIRE(a.field.rank() == b.field.rank());
  CHECK(a.field.weights() == b.field.weights());
  for (std::size_t k = 0; k < 2; ++k) CHECK(a.field.factors()[k] == b.field.factors()[k]);
  CHECK(a.message == b.message);
  const EvolutionResult c = solve(4);
  CHECK(c.status == samara::Termination::converged);
  CHECK((c.field.rank() != a.field.rank() || c.field.weights() != a.field.weights()));
}

TEST_CASE("evolution problems and options that make no sense are refused") {
  const Fall fall;
  const EvolutionProblem good = fall.problem(2, 3, 4);
  const auto refused = [&](const std::function<void(EvolutionProblem&)>& change, const std::string& words) {
    EvolutionProblem problem = good;
    change(problem);
    CHECK_THROWS_AS(problem.validate(), samara::ArgumentError);
    CHECK_THROWS_WITH(solve_evolution(problem), Contains(words));
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  CHECK_NOTHROW(good.validate());
  refused([](EvolutionProblem& p) { p.system = nullptr; }, "no system");
  refused([](EvolutionProblem& p) { p.states.push_back({"v"}); }, "1 states; 2 labels");
  refused([](EvolutionProblem& p) { p.scales.clear(); }, "0 scales");
  refused([](EvolutionProblem& p) { p.initial.clear(); }, "0 initial values");
  refused([](EvolutionProblem& p) { p.scales[0] = 0.0; }, "scale of u is 0");
  refused([](EvolutionProblem& p) { p.scales[0] = -1.0; }, "scale of u is -1");
  refused([&](EvolutionProblem& p) { p.scales[0] = kNan; }, "scale of u is nan");
  refused([](EvolutionProblem& p) { p.initial[0].axis = 1; }, "axis 1 of 1");
  refused([&](EvolutionProblem& p) { p.initial[0].value = kNan; }, "initial value of u is nan");

  const auto refused_options = [&](const EvolutionOptions& options, const std::string& words) {
    CHECK_THROWS_AS(solve_evolution(good, options), samara::ArgumentError);
    CHECK_THROWS_WITH(solve_evolution(good, options), Contains(words));
  };
  refused_options({.tolerance = 0.0}, "tolerance 0");
  refused_options({.tolerance = kNan}, "tolerance nan");
  refused_options({.max_iterations = 0}, "max_iterations 0");
  refused_options({.max_rank = 0}, "max_rank 0");
  refused_options({.linear_tolerance = 0.0}, "linear_tolerance 0");
}
