#include "samara/pgd/nonlinear/decoupling.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "../slab_systems.h"
#include "samara/base/errors.h"
#include "samara/pgd/evolution/polynomial_system.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

/// (6.22) with its coupled terms known one by one.
PolynomialSystem products() {
  std::vector<Monomial> terms;
  for (int m = 0; m < 3; ++m) {
    std::vector<int> others = {1, 1, 1};
    others[static_cast<std::size_t>(m)] = 0;
    terms.push_back({m, m + 1.0});
    terms.push_back({m, -1.0, {}, others});
  }
  return {3, 3, terms};
}

EvolutionProblem products_problem(const EvolutionSystem& system, double end, int elements, int nodes) {
  EvolutionProblem problem{
      &system, Axis::radau({"t", "1", AxisRole::time}, 0.0, end, elements, 6), {}, {}, {}, {}};
  for (int k = 0; k < 3; ++k) {
    const char* const names[] = {"u1", "u2", "u3"};
    const char* const starts[] = {"u1(0)", "u2(0)", "u3(0)"};
    problem.parameters.push_back(Axis::chebyshev({starts[k], "1", AxisRole::initial}, 0.0, 1.0, nodes));
    problem.states.push_back({names[k], "1"});
    problem.scales.push_back(1.0);
    problem.initial.push_back({0.0, k});
  }
  return problem;
}

/// Largest error at random points, over the ranges of the unknowns there.
double products_error(const DecouplingResult& result, double end) {
  const slab_systems::System exact = slab_systems::triple_product();
  Random random(7);
  Eigen::Array3d lowest = Eigen::Array3d::Constant(1e300), highest = -lowest,
                 largest = Eigen::Array3d::Zero();
  for (int i = 0; i < 400; ++i) {
    const std::vector<double> x = {end * random.uniform(), random.uniform(), random.uniform(),
                                   random.uniform()};
    const Eigen::Vector3d start(x[1], x[2], x[3]);
    const Eigen::Array3d u = exact.exact(start, start, x[0]).array();
    lowest = lowest.min(u);
    highest = highest.max(u);
    largest = largest.max((result.value_at(x).array() - u).abs());
  }
  return (largest / (highest - lowest)).maxCoeff();
}

}  // namespace

TEST_CASE("decoupled, the products (6.22) are solved to 1e-5 over the box in eight iterations a slab") {
  const PolynomialSystem system = products();
  const EvolutionProblem problem = products_problem(system, 0.8, 8, 12);
  const DecouplingResult result = solve_decoupled(problem, {.tolerance = 3e-6, .slabs = 8});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::converged);
  CHECK(result.reached == 0.8);
  CHECK(products_error(result, 0.8) <= 1e-5);
  CHECK(result.largest_iterations() <= 8);
  CHECK(result.largest_contraction() < 0.5);
}

TEST_CASE("unknowns held as trains meet the same, over the whole time axis at once, too") {
  const PolynomialSystem system = products();
  const EvolutionProblem problem = products_problem(system, 0.8, 8, 12);
  for (const int slabs : {1, 4}) {
    const DecouplingResult result =
        solve_decoupled(problem, {.tolerance = 1e-7, .slabs = slabs, .form = DecoupledForm::trains});
    CAPTURE(slabs, result.message);
    CHECK(result.status == samara::Termination::converged);
    CHECK(products_error(result, 0.8) <= 1e-6);
    CHECK(result.largest_contraction() < 0.7);
  }
}

TEST_CASE("decoupling contracts over a whole time axis, too, and either projection leads there") {
  const PolynomialSystem system = products();
  const EvolutionProblem problem = products_problem(system, 0.4, 2, 10);
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    const DecouplingResult result = solve_decoupled(problem, {.tolerance = 1e-6, .projection = projection});
    CAPTURE(result.message);
    CHECK(result.status == samara::Termination::converged);
    CHECK(products_error(result, 0.4) <= 1e-5);
    // A Picard iteration: its corrections fall faster than any geometric sequence.
    CHECK(result.history.back().contraction < result.largest_contraction());
  }
}

TEST_CASE("decoupling that loses contraction ends with a status that names where") {
  const PolynomialSystem system = products();
  const EvolutionProblem problem = products_problem(system, 1.6, 4, 8);
  const DecouplingResult result = solve_decoupled(problem, {.tolerance = 1e-4});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::diverged);
  CHECK_THAT(result.message, Contains("contraction is lost") && Contains("between t = 0 and 1.6"));
  CHECK(result.slabs.empty());
  // From (0, 1, 1) the solution ceases to exist at t = 0.953.
  REQUIRE(result.where.size() == 4);
  CHECK(result.where[0] > 0.95);
  CHECK(result.where[1] == 0.0);
  CHECK(result.where[2] == 1.0);
  CHECK(result.where[3] == 1.0);
}

TEST_CASE("what an unknown does to itself stays in its own linear problem") {
  // u' = -k u, v' = u - v: coupled one way, so that the second iteration changes nothing.
  const PolynomialSystem system(2, 1,
                                {{0, -1.0, {1}, {1, 0}}, {1, 1.0, {0}, {1, 0}}, {1, -1.0, {0}, {0, 1}}});
  const EvolutionProblem problem{&system,
                                 Axis::radau({"t", "s", AxisRole::time}, 0.0, 3.0, 2, 9),
                                 {Axis::chebyshev({"k", "1/s"}, 2.0, 4.0, 14)},
                                 {{"u"}, {"v"}},
                                 {1.0, 1.0},
                                 {{1.0, -1}, {0.0, -1}}};
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    const DecouplingResult result = solve_decoupled(problem, {.tolerance = 1e-6, .projection = projection});
    CAPTURE(result.message);
    REQUIRE(result.status == samara::Termination::converged);
    for (const double t : {0.3, 1.7, 3.0}) {
      for (const double k : {2.1, 3.7}) {
        const Eigen::VectorXd u = result.value_at(std::vector{t, k});
        CHECK(u[0] == Approx(std::exp(-k * t)).margin(1e-5));
        CHECK(u[1] == Approx((std::exp(-t) - std::exp(-k * t)) / (k - 1.0)).margin(1e-5));
      }
    }
  }
}

TEST_CASE("decoupling says when its terms or its iterations are used up, and when it was cancelled") {
  const PolynomialSystem system = products();
  const EvolutionProblem problem = products_problem(system, 0.4, 2, 8);
  const DecouplingResult terms = solve_decoupled(problem, {.tolerance = 1e-6, .max_rank = 4});
  CHECK(terms.status == samara::Termination::rank_limit);
  const DecouplingResult ranks =
      solve_decoupled(problem, {.tolerance = 1e-6, .form = DecoupledForm::trains, .max_rank = 4});
  CHECK(ranks.status == samara::Termination::rank_limit);
  CHECK_THAT(ranks.message, Contains("4 are allowed"));
  for (const DecouplingRecord& record : ranks.history) CHECK(std::isfinite(record.linear_residual));
  CHECK_THAT(terms.message, Contains("of at most 4"));
  const DecouplingResult iterations = solve_decoupled(problem, {.tolerance = 1e-6, .max_iterations = 3});
  CHECK(iterations.status == samara::Termination::max_iterations);
  CHECK(iterations.history.size() == 3);
  const DecouplingResult cancelled =
      solve_decoupled(problem, {.progress = [](const samara::Progress&) { return false; }});
  CHECK(cancelled.status == samara::Termination::cancelled);
}

TEST_CASE("decoupling asks for a polynomial system and a time axis of slabs") {
  const slab_systems::System unknown = slab_systems::triple_product();
  CHECK_THROWS_WITH(solve_decoupled(products_problem(unknown, 0.4, 2, 5)), Contains("PolynomialSystem"));
  const PolynomialSystem system = products();
  CHECK_THROWS_WITH(solve_decoupled(products_problem(system, 0.4, 2, 5), {.slabs = 3}),
                    Contains("2 elements of the kind radau for 3 slabs"));
  CHECK_THROWS_WITH(solve_decoupled(products_problem(system, 0.4, 2, 5), {.tolerance = 0.0}),
                    Contains("tolerance 0"));
  const DecouplingResult none;
  CHECK_THROWS_AS(none.value_at(std::vector{0.0}), samara::ArgumentError);
}
