#include <cmath>

#include <catch2/catch.hpp>

#include "examples/linear_engine/poisson.h"
#include "random_tensor.h"
#include "samara/base/errors.h"
#include "samara/pgd/enrichment.h"
#include "samara/pgd/residual.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

EnrichOptions galerkin(int max_rank, double tolerance = 1e-12) {
  EnrichOptions options;
  options.projection = Projection::galerkin;
  options.residual_tolerance = tolerance;
  options.max_rank = max_rank;
  return options;
}

/// Diffusion on three modes of very different strength: the fixed point creeps.
LinearProblem creeping() {
  LinearProblem problem = poisson(3, 15);
  problem.rhs = random_tensor({15, 15, 15}, 40, 3);
  return problem;
}

}  // namespace

TEST_CASE("a solve resumed from any checkpoint gives the same bits as the undisturbed one") {
  const LinearProblem problem = poisson(4, 12);
  std::vector<EnrichState> states;
  EnrichOptions options = galerkin(9);
  options.checkpoint = [&](const EnrichState& state) { states.push_back(state); };
  const EnrichResult whole = enrich(problem, options);
  REQUIRE(states.size() == 9);
  for (const std::size_t at : {std::size_t{0}, std::size_t{3}, std::size_t{8}}) {
    const EnrichResult resumed = enrich(problem, galerkin(9), states[at]);
    CHECK(resumed.residual == whole.residual);
    CHECK(resumed.history.size() == whole.history.size());
    REQUIRE(resumed.solution.rank() == whole.solution.rank());
    CHECK(resumed.solution.weights == whole.solution.weights);
    for (std::size_t k = 0; k < 4; ++k) CHECK(resumed.solution.factors[k] == whole.solution.factors[k]);
  }
}

TEST_CASE("a state of another problem is refused") {
  EnrichState state;
  state.solution = SeparatedTensor::zero(std::vector<int>{5, 5});
  CHECK_THROWS_WITH(enrich(poisson(2, 6), galerkin(3), state), Contains("5 x 5") && Contains("6 x 6"));
}

TEST_CASE("a warm start from the solution ends at once, from a perturbed one it goes on from there") {
  const LinearProblem problem = poisson(3, 15);
  const EnrichResult cold = enrich(problem, galerkin(12, 1e-3));
  REQUIRE(cold.termination == Termination::residual);
  const EnrichResult again = enrich(problem, galerkin(12, 1e-3), &cold.solution);
  CHECK(again.history.empty());
  CHECK(again.termination == Termination::residual);
  const EnrichResult further = enrich(problem, galerkin(40, 1e-6), &cold.solution);
  CHECK(further.termination == Termination::residual);
  CHECK(further.solution.rank() > cold.solution.rank());
}

TEST_CASE("time that is up is a named reason, before the next term") {
  EnrichOptions options = galerkin(60, 1e-15);
  options.max_seconds = 1e-9;
  const EnrichResult result = enrich(poisson(3, 31), options);
  CHECK(result.termination == Termination::max_time);
  CHECK(to_string(result.termination) == "max_time");
  CHECK_THAT(result.message, Contains("1e-09 s"));
}

TEST_CASE("acceleration takes fewer iterations to the same product") {
  int iterations[2] = {0, 0};
  double amplitude[2] = {0.0, 0.0};
  for (const Acceleration acceleration : {Acceleration::none, Acceleration::aitken}) {
    EnrichOptions options = galerkin(1);
    options.max_fixed_point_iterations = 2000;
    options.fixed_point_tolerance = 1e-9;
    options.acceleration = acceleration;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      options.seed = seed;
      const EnrichResult result = enrich(creeping(), options);
      REQUIRE(result.history.size() == 1);
      CHECK(result.history[0].fixed_point_converged);
      iterations[static_cast<int>(acceleration)] += result.history[0].fixed_point_iterations;
      amplitude[static_cast<int>(acceleration)] =
          std::max(amplitude[static_cast<int>(acceleration)], result.history[0].amplitude);
    }
  }
  CAPTURE(iterations[0], iterations[1]);
  CHECK(iterations[1] < iterations[0]);
  CHECK(amplitude[1] == Approx(amplitude[0]).epsilon(1e-6));
}

TEST_CASE("of several first guesses the product that gains most is taken") {
  double one = 0.0;
  double five = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    EnrichOptions options = galerkin(1);
    options.update_sweeps = 0;
    options.seed = seed;
    one += enrich(creeping(), options).residual;
    options.first_guesses = 5;
    five += enrich(creeping(), options).residual;
  }
  CHECK(five < one);
}

TEST_CASE("sweeps end early once they no longer change the weights") {
  const LinearProblem problem = poisson(3, 15);
  EnrichOptions many = galerkin(4);
  many.update_sweeps = 200;
  EnrichOptions early = many;
  early.update_tolerance = 1e-6;
  const EnrichResult long_run = enrich(problem, many);
  const EnrichResult short_run = enrich(problem, early);
  CHECK(short_run.residual == Approx(long_run.residual).epsilon(0.05));
  CHECK(short_run.residual > 0.0);
}

TEST_CASE("options out of range are refused by name") {
  const LinearProblem problem = poisson(2, 5);
  EnrichOptions options = galerkin(3);
  options.first_guesses = 0;
  CHECK_THROWS_WITH(enrich(problem, options), Contains("first_guesses is 0"));
  options = galerkin(3);
  options.max_seconds = std::nan("");
  CHECK_THROWS_WITH(enrich(problem, options), Contains("max_seconds"));
  options = galerkin(3);
  options.update_tolerance = -1.0;
  CHECK_THROWS_WITH(enrich(problem, options), Contains("update_tolerance is -1"));
}

TEST_CASE("a problem that cannot converge ends with a status, not with a claim") {
  // Zero on the first node of mode 0, but a source there.
  LinearProblem problem;
  Eigen::VectorXd diagonal = Eigen::VectorXd::Ones(5);
  diagonal[0] = 0.0;
  problem.op.terms = {{ModeOperator::diagonal(diagonal), ModeOperator::identity(4)}};
  problem.rhs = random_tensor({5, 4}, 2, 1);
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    const EnrichResult result = enrich(problem, {.projection = projection});
    CHECK(result.termination == Termination::singular);
    CHECK(result.residual > 0.1);
  }
}
