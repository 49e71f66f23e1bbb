#include "samara/pgd/linear/enrichment.h"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/linear/residual.h"
#include "samara/pgd/tensors/tensor_train.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

/// The axis without its first node, whose value is known.
SparseMatrix inner_block(const SparseMatrix& matrix) {
  return matrix.block(1, 1, matrix.rows() - 1, matrix.cols() - 1);
}

/// k (u' + 1) = 10, u(0) = 0, (6.18) of the dissertation, in the weak form (6.8)-(6.9) on finite elements in
/// k and collocation in time. Exact: u = (10 / k - 1) t.
struct ParametricLine {
  Axis t = Axis::radau({"t", "1", AxisRole::time}, 0.0, 10.0, 4, 3);
  Axis k = Axis::chebyshev({"k"}, 1.0, 10.0, 40);
  LinearProblem problem() const {
    const Eigen::VectorXd nodes = k.nodes();
    SeparatedOperator op{
        {{ModeOperator::sparse(inner_block(t.derivative())), ModeOperator::diagonal(nodes)}}};
    const Eigen::VectorXd rhs_k = 10.0 - nodes.array();
    SeparatedTensor rhs = SeparatedTensor::product({Eigen::VectorXd::Ones(t.size() - 1), rhs_k});
    return {op, rhs, {t.weights().tail(t.size() - 1), k.weights()}};
  }
  double exact(double time, double parameter) const { return (10.0 / parameter - 1.0) * time; }
};

/// -Laplace u = 1 on the unit square, u = 0 on its border, second-order differences on n x n inner nodes.
LinearProblem poisson(int n) {
  const double h = 1.0 / (n + 1);
  std::vector<Eigen::Triplet<double>> triplets;
  for (int i = 0; i < n; ++i) {
    triplets.emplace_back(i, i, 2.0 / (h * h));
    if (i > 0) triplets.emplace_back(i, i - 1, -1.0 / (h * h));
    if (i + 1 < n) triplets.emplace_back(i, i + 1, -1.0 / (h * h));
  }
  SparseMatrix laplace(n, n);
  laplace.setFromTriplets(triplets.begin(), triplets.end());
  const auto identity = ModeOperator::identity(n);
  const auto second = ModeOperator::sparse(laplace);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
  return {SeparatedOperator{{{second, identity}, {identity, second}}},
          SeparatedTensor::product({ones, ones}),
          {}};
}

/// u' + k u = 1, u(0) = 0: an evolution operator, not symmetric.
LinearProblem relaxation() {
  const Axis t = Axis::radau({"t", "s", AxisRole::time}, 0.0, 2.0, 6, 4);
  const Axis k = Axis::chebyshev({"k"}, 1.0, 4.0, 12);
  const int n = t.size() - 1;
  SeparatedOperator op{{{ModeOperator::sparse(inner_block(t.derivative())), ModeOperator::identity(k.size())},
                        {ModeOperator::identity(n), ModeOperator::diagonal(k.nodes())}}};
  return {op,
          SeparatedTensor::product({Eigen::VectorXd::Ones(n), Eigen::VectorXd::Ones(k.size())}),
          {t.weights().tail(n), k.weights()}};
}

}  // namespace

TEST_CASE("the parametric line (6.18) is solved by one term to 1e-12") {
  const ParametricLine line;
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    const EnrichResult result =
        enrich(line.problem(), {.projection = projection, .residual_tolerance = 1e-12});
    CHECK(result.termination == samara::Termination::converged);
    REQUIRE(result.solution.rank() == 1);
    double error = 0.0;
    for (int i = 1; i < line.t.size(); ++i) {
      for (int j = 0; j < line.k.size(); ++j) {
        const std::vector<int> index = {i - 1, j};
        const double exact = line.exact(line.t.nodes()[i], line.k.nodes()[j]);
        error = std::max(error, std::abs(result.solution.entry(index) - exact));
      }
    }
    CHECK(error < 1e-12 * 90.0);  // 90 = largest |u|
  }
}

TEST_CASE("the finite element form (6.8)-(6.9) of u' + k u = 0 converges with second order") {
  // With u = 1 + w: w' + k w = -k, w(0) = 0. P, N, M of (6.9) on P1 axes; the row of P carries the test
  // function.
  const auto error = [](int n) {
    const Axis t = Axis::p1({"t"}, 0.0, 1.0, n);
    const Axis k = Axis::p1({"k"}, 1.0, 3.0, n);
    SparseMatrix k_mass(
        n, n);  // integral of N_i k N_j, k linear: three-point Gauss-Lobatto (Simpson) is exact to 3
    std::vector<Eigen::Triplet<double>> triplets;
    for (int e = 0; e + 1 < n; ++e) {
      const double h = k.nodes()[e + 1] - k.nodes()[e];
      const double a = k.nodes()[e], b = k.nodes()[e + 1];
      triplets.emplace_back(e, e, h * (3 * a + b) / 12);
      triplets.emplace_back(e, e + 1, h * (a + b) / 12);
      triplets.emplace_back(e + 1, e, h * (a + b) / 12);
      triplets.emplace_back(e + 1, e + 1, h * (a + 3 * b) / 12);
    }
    k_mass.setFromTriplets(triplets.begin(), triplets.end());
    const Eigen::VectorXd rhs_k = -k_mass * Eigen::VectorXd::Ones(n);
    const Eigen::VectorXd rhs_t = t.weights().tail(n - 1);
    LinearProblem problem{
        SeparatedOperator{{{ModeOperator::sparse(inner_block(t.gradient())), ModeOperator::sparse(k.mass())},
                           {ModeOperator::sparse(inner_block(t.mass())), ModeOperator::sparse(k_mass)}}},
        SeparatedTensor::product({rhs_t, rhs_k}),
        {}};
    const EnrichResult result =
        enrich(problem, {.projection = Projection::galerkin, .residual_tolerance = 1e-9, .max_rank = 20});
    CHECK(result.termination == samara::Termination::converged);
    double largest = 0.0;
    for (int i = 1; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const std::vector<int> index = {i - 1, j};
        const double exact = std::exp(-k.nodes()[j] * t.nodes()[i]) - 1.0;
        largest = std::max(largest, std::abs(result.solution.entry(index) - exact));
      }
    }
    return largest;
  };
  CHECK(std::log2(error(17) / error(33)) > 1.85);
}

TEST_CASE("Poisson's problem reaches its published centre value and Galerkin needs few terms") {
  const EnrichResult result =
      enrich(poisson(63), {.projection = Projection::galerkin, .residual_tolerance = 1e-7, .max_rank = 20});
  CHECK(result.termination == samara::Termination::converged);
  const std::vector<int> centre = {31, 31};
  // 0.0736713 is the continuous value; differences on 63 nodes give 0.073657.
  CHECK(result.solution.entry(centre) == Approx(0.073657).margin(1e-6));
  CHECK(result.solution.rank() <= 10);
}

TEST_CASE("the minimal residual never increases from term to term") {
  for (const LinearProblem& problem : {relaxation(), poisson(15)}) {
    const EnrichResult result = enrich(problem, {.residual_tolerance = 1e-10, .max_rank = 12});
    for (std::size_t r = 1; r < result.history.size(); ++r) {
      CHECK(result.history[r].residual <= result.history[r - 1].residual * (1.0 + 1e-9));
    }
  }
}

TEST_CASE("factor updates save terms against the projection of weights alone") {
  const LinearProblem problem = relaxation();
  const EnrichResult weights_only =
      enrich(problem, {.residual_tolerance = 1e-6, .max_rank = 60, .update_sweeps = 0});
  const EnrichResult updated =
      enrich(problem, {.residual_tolerance = 1e-6, .max_rank = 60, .update_sweeps = 2});
  REQUIRE(updated.termination == samara::Termination::converged);
  CHECK(updated.solution.rank() < weights_only.solution.rank());
}

TEST_CASE("both projections agree with the exact solution of u' + k u = 1") {
  const Axis t = Axis::radau({"t", "s", AxisRole::time}, 0.0, 2.0, 6, 4);
  const Axis k = Axis::chebyshev({"k"}, 1.0, 4.0, 12);
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    const EnrichResult result = enrich(relaxation(), {.projection = projection, .residual_tolerance = 1e-9});
    CHECK(result.termination == samara::Termination::converged);
    for (int j = 0; j < k.size(); ++j) {
      const std::vector<int> end = {t.size() - 2, j};
      const double exact = (1.0 - std::exp(-2.0 * k.nodes()[j])) / k.nodes()[j];
      CHECK(result.solution.entry(end) == Approx(exact).epsilon(1e-7));
    }
  }
}

TEST_CASE("the reported residual is the exact one") {
  const LinearProblem problem = relaxation();
  const EnrichResult result = enrich(problem, {.residual_tolerance = 1e-4});
  CHECK(result.residual == Approx(relative_residual(problem, result.solution)).epsilon(1e-3));
}

TEST_CASE("the same seed gives the same solution to the last bit") {
  const LinearProblem problem = relaxation();
  const EnrichResult a = enrich(problem, {.residual_tolerance = 1e-7, .seed = 5});
  const EnrichResult b = enrich(problem, {.residual_tolerance = 1e-7, .seed = 5});
  REQUIRE(a.solution.rank() == b.solution.rank());
  CHECK(a.solution.weights == b.solution.weights);
  CHECK(a.solution.factors[0] == b.solution.factors[0]);
}

TEST_CASE("every reason to stop is named with its numbers") {
  const LinearProblem problem = relaxation();
  CHECK(enrich(problem, {.residual_tolerance = 1e-12, .max_rank = 2}).termination ==
        samara::Termination::rank_limit);
  const EnrichResult small = enrich(problem, {.residual_tolerance = 1e-15, .amplitude_tolerance = 1e-2});
  CHECK(small.termination == samara::Termination::converged);
  CHECK_THAT(small.message, Contains("has amplitude") && Contains("below 0.01 of the largest"));
  EnrichOptions cancelled;
  cancelled.progress = [](const samara::Progress&) { return false; };
  CHECK(enrich(problem, cancelled).termination == samara::Termination::cancelled);

  LinearProblem singular = problem;
  for (auto& term : singular.op.terms) term[1] = ModeOperator::diagonal(Eigen::VectorXd::Zero(12));
  const EnrichResult failed = enrich(singular);
  CHECK(failed.termination == samara::Termination::failed);
  CHECK_THAT(failed.message, Contains("singular at term 1"));

  LinearProblem empty = problem;
  empty.rhs = SeparatedTensor::zero(problem.rhs.sizes());
  const EnrichResult nothing = enrich(empty);
  CHECK(nothing.termination == samara::Termination::converged);
  CHECK(nothing.solution.rank() == 0);
}

TEST_CASE("a problem that does not fit together is refused with the mode and the sizes") {
  LinearProblem problem = relaxation();
  problem.rhs.factors[1].conservativeResize(7, Eigen::NoChange);
  CHECK_THROWS_WITH(enrich(problem), Contains("mode 1") && Contains("7 rows"));
  problem = relaxation();
  problem.rhs.factors[0](3, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(enrich(problem), Contains("mode 0") && Contains("not finite"));
  problem = relaxation();
  problem.row_weights[1][0] = -1.0;
  CHECK_THROWS_WITH(enrich(problem), Contains("mode 1") && Contains("positive"));
  problem = relaxation();
  problem.op.terms.clear();
  CHECK_THROWS_WITH(enrich(problem), Contains("no operator"));
  CHECK_THROWS_WITH(enrich(relaxation(), {.residual_tolerance = 0.0}), Contains("residual_tolerance is 0"));
}
