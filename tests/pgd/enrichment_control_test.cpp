#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "examples/linear_engine/poisson.h"
#include "random_tensor.h"
#include "samara/base/errors.h"
#include "samara/pgd/linear/enrichment.h"
#include "samara/pgd/linear/parametric_problem.h"
#include "samara/pgd/linear/residual.h"

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
  REQUIRE(cold.termination == samara::Termination::converged);
  const EnrichResult again = enrich(problem, galerkin(12, 1e-3), &cold.solution);
  CHECK(again.history.empty());
  CHECK(again.termination == samara::Termination::converged);
  const EnrichResult further = enrich(problem, galerkin(40, 1e-6), &cold.solution);
  CHECK(further.termination == samara::Termination::converged);
  CHECK(further.solution.rank() > cold.solution.rank());
}

TEST_CASE("time that is up is a named reason, before the next term") {
  EnrichOptions options = galerkin(60, 1e-15);
  options.max_seconds = 1e-9;
  const EnrichResult result = enrich(poisson(3, 31), options);
  CHECK(result.termination == samara::Termination::max_seconds);
  CHECK(to_string(result.termination) == "max_seconds");
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
    CHECK(result.termination == samara::Termination::failed);
    CHECK(result.residual > 0.1);
  }
}

TEST_CASE("a singular operator is never solved to a claimed residual") {
  // Insulated on both sides: constants are free, and the source has nowhere to go.
  for (const int elements : {10, 20, 40, 63, 100}) {
    const Axis x = Axis::p1({"x", "m", AxisRole::space}, 0.0, 1.0, elements + 1);
    const Axis k = Axis::chebyshev({"k"}, 1.0, 2.0, 5);
    ParametricProblem problem({x, k});
    problem.add_term({{"x", ModeOperator::sparse(x.stiffness())}, {"k", ModeOperator::diagonal(k.nodes())}});
    problem.add_source({});
    for (const SparseSolverKind kind :
         {SparseSolverKind::automatic, SparseSolverKind::eigen_lu, SparseSolverKind::umfpack}) {
      if (!is_available(kind)) continue;
      EnrichOptions options = galerkin(10, 1e-8);
      options.solver = kind;
      const EnrichResult result = enrich(problem.assemble(), options);
      CAPTURE(elements, to_string(kind), result.message);
      CHECK(result.termination != samara::Termination::converged);
      CHECK(result.residual > 1e-2);
    }
  }
}

TEST_CASE("terms that cancel do not hide a residual from the cheap measure") {
  LinearProblem problem = poisson(2, 8);
  SeparatedTensor large = random_tensor({8, 8}, 2, 3);
  problem.rhs.append(large, 1e7);
  problem.rhs.append(large, -1e7);
  const EnrichResult result = enrich(problem, galerkin(20, 1e-7));
  CHECK(result.termination == samara::Termination::converged);
  EnrichOptions fast = galerkin(20, 1e-12);
  fast.residual = ResidualKind::fast;
  CHECK(enrich(problem, fast).residual > 0.0);
  CHECK(enrich(problem, fast).termination != samara::Termination::converged);
}

namespace {

/// U -> A U + U A^T with A = 1 + a N, N a shift: the further from normal, the larger a.
LinearProblem far_from_normal(double a, std::uint64_t seed) {
  Eigen::MatrixXd upper = Eigen::MatrixXd::Identity(6, 6);
  for (int i = 0; i + 1 < 6; ++i) upper(i, i + 1) = a;
  LinearProblem problem;
  problem.op.terms = {{ModeOperator::dense(upper), ModeOperator::identity(6)},
                      {ModeOperator::identity(6), ModeOperator::dense(upper)}};
  problem.rhs = random_tensor({6, 6}, 2, seed);
  return problem;
}

}  // namespace

TEST_CASE("where Galerkin's residual rises the best state met is returned, also after a resumption") {
  int rose = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const LinearProblem problem = far_from_normal(4.0, seed);
    EnrichOptions options = galerkin(8, 1e-13);
    options.stagnation_terms = 8;
    std::vector<EnrichState> states;
    options.checkpoint = [&](const EnrichState& state) { states.push_back(state); };
    const EnrichResult result = enrich(problem, options);
    double lowest = 1.0;  // of the solution without terms
    for (const TermRecord& record : result.history) lowest = std::min(lowest, record.residual);
    CHECK(result.residual == lowest);
    CHECK(relative_residual(problem, result.solution) == Approx(lowest).epsilon(1e-6));
    if (result.history.back().residual == lowest) continue;
    ++rose;
    CHECK_THAT(result.message, Contains("best residual"));
    options.checkpoint = {};
    const EnrichResult resumed = enrich(problem, options, states[states.size() - 2]);
    CHECK(resumed.residual == result.residual);
    CHECK(resumed.solution.weights == result.solution.weights);
  }
  CHECK(rose > 0);
}

TEST_CASE("the minimal residual never increases, not even for operators far from normal") {
  for (const double a : {4.0, 10.0, 20.0}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const LinearProblem problem = far_from_normal(a, seed);
      EnrichOptions options;
      options.max_rank = 12;
      options.stagnation_terms = 12;
      options.residual_tolerance = 1e-13;
      options.update_sweeps = static_cast<int>(seed % 3) * 2;
      const EnrichResult result = enrich(problem, options);
      for (std::size_t r = 1; r < result.history.size(); ++r)
        CHECK(result.history[r].residual <= result.history[r - 1].residual);
      CHECK(result.residual == Approx(relative_residual(problem, result.solution)).epsilon(0.05));
    }
  }
}

TEST_CASE("starts that are broken, too long or empty are refused or harmless") {
  const LinearProblem problem = poisson(2, 6);
  SeparatedTensor start = random_tensor({6, 6}, 2, 1);
  start.factors[1](2, 0) = std::nan("");
  CHECK_THROWS_WITH(enrich(problem, galerkin(5), &start), Contains("start") && Contains("mode 1"));
  start = random_tensor({6, 6}, 3, 1);
  CHECK_THROWS_WITH(enrich(problem, galerkin(2), &start), Contains("3 terms") && Contains("max_rank"));
  start.factors[1].conservativeResize(Eigen::NoChange, 1);
  CHECK_THROWS_WITH(enrich(problem, galerkin(5), &start), Contains("3 weights") && Contains("1 columns"));
  start = random_tensor({6, 6}, 1, 1);
  start.weights[0] = 0.0;
  CHECK(enrich(problem, galerkin(12, 1e-6), &start).termination == samara::Termination::converged);
  start = SeparatedTensor::zero(std::vector<int>{6, 7});
  CHECK_THROWS_WITH(enrich(problem, galerkin(5), &start), Contains("6 x 7"));
}

TEST_CASE("a state whose residual is not its solution's in this problem is refused") {
  EnrichState state;
  EnrichOptions options = galerkin(3);
  options.checkpoint = [&](const EnrichState& s) { state = s; };
  enrich(poisson(2, 6), options);
  LinearProblem other = poisson(2, 6);
  other.rhs.weights *= 2.0;
  CHECK_THROWS_WITH(enrich(other, galerkin(5), state), Contains("belongs to another"));
  state.residual = 1e-9;
  CHECK_THROWS_WITH(enrich(poisson(2, 6), galerkin(5), state), Contains("belongs to another"));
}

TEST_CASE("a right-hand side that vanishes has the solution without terms, also from a warm start") {
  LinearProblem problem = poisson(2, 6);
  problem.rhs.append(problem.rhs, -1.0);
  const SeparatedTensor start = random_tensor({6, 6}, 2, 1);
  for (const SeparatedTensor* from : {static_cast<const SeparatedTensor*>(nullptr), &start}) {
    const EnrichResult result = enrich(problem, galerkin(5), from);
    CHECK(result.termination == samara::Termination::converged);
    CHECK(result.solution.rank() == 0);
    CHECK(result.residual == 0.0);
  }
}

TEST_CASE("problems that do not fit together, or leave the range of doubles, are refused") {
  LinearProblem problem = poisson(2, 6);
  problem.row_weights = std::vector<Eigen::VectorXd>(3, Eigen::VectorXd::Ones(6));
  CHECK_THROWS_WITH(enrich(problem, galerkin(3)), Contains("3 row weights") && Contains("2 modes"));
  problem = poisson(2, 6);
  problem.rhs.weights = Eigen::VectorXd::Ones(5);
  CHECK_THROWS_WITH(enrich(problem, galerkin(3)), Contains("5 weights"));
  problem = poisson(2, 6);
  problem.rhs.factors[0] *= 1e-170;
  CHECK_THROWS_WITH(enrich(problem, galerkin(3)), Contains("1e-170") && Contains("1e-100 to 1e100"));
}

TEST_CASE("dense and diagonal operators of many magnitudes are regular") {
  const Eigen::VectorXd values = Eigen::Vector3d(1.0, 1e-10, 1e-20);
  LinearProblem problem;
  problem.op.terms = {{ModeOperator::dense(values.asDiagonal()), ModeOperator::identity(2)}};
  problem.rhs = SeparatedTensor::product({values, Eigen::Vector2d(1.0, 1.0)});
  CHECK(enrich(problem, galerkin(3)).termination == samara::Termination::converged);
}
