#include "samara/pgd/linear/parametric_problem.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/axes/axis_forms.h"
#include "samara/pgd/cross/separate_function.h"
#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/linear/enrichment.h"
#include "samara/pgd/tensors/random.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

constexpr AxisRole kSpace = AxisRole::space;

SeparatedField solved(const ParametricProblem& problem, Projection projection = Projection::galerkin) {
  EnrichOptions options;
  options.projection = projection;
  options.residual_tolerance = 1e-10;
  options.update_sweeps = 4;
  const EnrichResult result = enrich(problem.assemble(), options);
  CAPTURE(result.message);
  REQUIRE(result.termination == samara::Termination::converged);
  const SeparatedTensor u = problem.complete(result.solution);
  return {problem.axes(), {{"u"}}, u.factors, u.weights.transpose()};
}

/// Largest difference at random points of the box.
template <class Exact>
double error_of(const SeparatedField& field, Exact exact) {
  Random random(17);
  double largest = 0.0;
  for (int i = 0; i < 200; ++i) {
    std::vector<double> x;
    for (const Axis& axis : field.axes()) x.push_back(axis.lower() + random.uniform() * axis.length());
    largest = std::max(largest, std::abs(field(x)[0] - exact(x)));
  }
  return largest;
}

}  // namespace

TEST_CASE("boundary values of all three kinds are coordinates of the solution") {
  // -k u'' = 0 on (0,1), u(0) = g, k u'(1) = h (t - u(1)) + n: Dirichlet, Robin and Neumann data at once.
  // Exact: u = g + c x with k c = h (t - g - c) + n.
  const double h = 2.0;
  const Axis x = Axis::legendre({"x", "1", kSpace}, 0.0, 1.0, 5);
  const Axis k = Axis::chebyshev({"k"}, 0.5, 2.0, 18);
  const Axis g = Axis::chebyshev({"g", "1", AxisRole::boundary}, -1.0, 1.0, 3);
  const Axis t = Axis::chebyshev({"t", "1", AxisRole::boundary}, 0.0, 3.0, 3);
  const Axis n = Axis::chebyshev({"n", "1", AxisRole::boundary}, -1.0, 2.0, 3);
  ParametricProblem problem({x, k, g, t, n});
  const Eigen::VectorXd end = point_load(x, 1.0);
  const SparseMatrix robin = (end * end.transpose()).sparseView();
  problem.add_term({{"x", ModeOperator::sparse(x.stiffness())}, {"k", ModeOperator::diagonal(k.nodes())}});
  problem.add_term({{"x", ModeOperator::sparse(robin)}}, h);
  problem.add_source({{"x", end}, {"t", t.nodes()}}, h);
  problem.add_source({{"x", end}, {"n", n.nodes()}});
  problem.know("x", {0});
  problem.add_to_lift({{"g", g.nodes()}});
  const double error = error_of(solved(problem), [&](const std::vector<double>& at) {
    const double c = (h * (at[3] - at[2]) + at[4]) / (at[1] + h);
    return at[2] + c * at[0];
  });
  CHECK(error < 1e-8);
}

TEST_CASE("an initial value is a coordinate of the solution") {
  // u' + k u = 0, u(0) = a: u = a exp(-k t).
  const Axis t = Axis::radau({"t", "s", AxisRole::time}, 0.0, 2.0, 8, 5);
  const Axis k = Axis::chebyshev({"k"}, 0.5, 2.0, 16);
  const Axis a = Axis::chebyshev({"a", "1", AxisRole::initial}, 1.0, 3.0, 2);
  ParametricProblem problem({t, k, a});
  problem.add_term({{"t", ModeOperator::sparse(t.derivative())}});
  problem.add_term({{"k", ModeOperator::diagonal(k.nodes())}});
  problem.know("t", {0});
  problem.add_to_lift({{"a", a.nodes()}});
  const double error =
      error_of(solved(problem, Projection::minimal_residual),
               [](const std::vector<double>& at) { return at[2] * std::exp(-at[1] * at[0]); });
  CHECK(error < 1e-6);
}

TEST_CASE("a coefficient that is not affine is separated first") {
  const Axis x = Axis::legendre({"x", "1", kSpace}, 0.0, 1.0, 12);
  const Axis m = Axis::chebyshev({"m"}, 0.2, 1.5, 14);
  const auto coefficient = [](std::span<const double> at) { return std::exp(at[0] * at[1]); };
  const SeparatedFunction k = separate(coefficient, {x, m}, {.tolerance = 1e-10});
  REQUIRE(k.tolerance_met);
  // -(exp(m x) u')' = f with u = 1 - exp(-m x): exp(m x) u' = m, so f = 0 and the flux at x = 1 is m.
  ParametricProblem problem({x, m});
  for (Eigen::Index r = 0; r < k.tensor.rank(); ++r) {
    const Eigen::VectorXd in_x = k.tensor.factors[0].col(r);
    problem.add_term({{"x", ModeOperator::sparse(weighted_stiffness(x, in_x))},
                      {"m", ModeOperator::diagonal(k.tensor.factors[1].col(r))}},
                     k.tensor.weights[r]);
  }
  problem.add_source({{"x", point_load(x, 1.0)}, {"m", m.nodes()}});
  problem.know("x", {0});
  const double error = error_of(solved(problem, Projection::minimal_residual),
                                [](const std::vector<double>& at) { return 1.0 - std::exp(-at[1] * at[0]); });
  CHECK(error < 1e-7);
}

TEST_CASE("problems that do not fit together are refused by name") {
  const Axis x = Axis::p1({"x", "1", kSpace}, 0.0, 1.0, 5);
  const Axis k = Axis::chebyshev({"k"}, 1.0, 2.0, 3);
  CHECK_THROWS_WITH(ParametricProblem({x, x}), Contains("two axes") && Contains("\"x\""));
  CHECK_THROWS_WITH(ParametricProblem({}), Contains("no axes"));
  ParametricProblem problem({x, k});
  CHECK_THROWS_WITH(problem.assemble(), Contains("no term"));
  CHECK_THROWS_WITH(problem.add_source({{"y", x.nodes()}}), Contains("\"y\""));
  CHECK_THROWS_WITH(problem.add_source({{"x", k.nodes()}}),
                    Contains("\"x\"") && Contains("size 3, expected 5"));
  const Eigen::VectorXd broken = Eigen::VectorXd::Constant(5, std::nan(""));
  CHECK_THROWS_WITH(problem.add_source({{"x", broken}}), Contains("source") && Contains("not finite"));
  CHECK_THROWS_WITH(problem.add_to_lift({{"x", broken}}), Contains("lift") && Contains("not finite"));
  CHECK_THROWS_WITH(problem.add_term({{"x", ModeOperator::diagonal(broken)}}),
                    Contains("term") && Contains("not finite"));
  CHECK_THROWS_WITH(problem.add_term({}, std::nan("")), Contains("scale of a term is nan"));
  CHECK_THROWS_WITH(problem.know("x", {5}), Contains("no node 5"));
  problem.add_term({});
  problem.know("k", {0, 1, 2});
  CHECK_THROWS_WITH(problem.assemble(), Contains("\"k\"") && Contains("nothing is left"));
}

TEST_CASE("forms with a coefficient agree with the axis's own, and integrate products exactly") {
  for (const Axis& x :
       {Axis::p1({"x"}, 0.0, 2.0, 7), Axis::p2({"x"}, 0.0, 2.0, 5), Axis::legendre({"x"}, 0.0, 2.0, 8),
        Axis::chebyshev({"x", "1", AxisRole::parameter, Transform::logarithm}, 0.5, 2.0, 9)}) {
    const auto one = [](double) { return 1.0; };
    CHECK((weighted_mass(x, one) - x.mass()).norm() < 1e-11 * x.mass().norm());
    CHECK((weighted_stiffness(x, one) - x.stiffness()).norm() < 1e-9 * x.stiffness().norm());
    CHECK((weighted_gradient(x, one) - x.gradient()).norm() < 1e-10 * x.gradient().norm());
    CHECK((load_vector(x, one) - x.weights()).norm() < 1e-11 * x.weights().norm());
    // Integral of x * x over the interval through the nodal coefficient x.
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(x.size());
    if (x.transform() == Transform::none) {
      const double cubes = (std::pow(x.upper(), 3) - std::pow(x.lower(), 3)) / 3.0;
      CHECK(x.nodes().dot(weighted_mass(x, x.nodes()) * ones) == Approx(cubes).epsilon(1e-12));
    }
    CHECK(point_load(x, 1.1).sum() == Approx(1.0));
  }
  const Axis root = Axis::chebyshev({"r", "1", AxisRole::parameter, Transform::square_root}, 0.0, 1.0, 6);
  CHECK_THROWS_AS(weighted_stiffness(root, [](double) { return 1.0; }), samara::ArgumentError);
  const Axis x = Axis::p1({"x"}, 0.0, 1.0, 3);
  CHECK_THROWS_WITH(weighted_mass(x, [](double s) { return std::log(s - 1.0); }),
                    Contains("coefficient is") && Contains("x ="));
  CHECK_THROWS_WITH(point_load(x, 1.5), Contains("x = 1.5 is not in [0, 1]"));
  CHECK_THROWS_WITH(weighted_mass(x, Eigen::VectorXd::Ones(4)),
                    Contains("4 nodal values") && Contains("3 nodes"));
}

TEST_CASE("a separated function is within its tolerance at nodes it never saw, or says that it is not") {
  const std::vector<Axis> axes = {Axis::chebyshev({"a"}, 0.0, 1.0, 20), Axis::chebyshev({"b"}, 0.0, 1.0, 20),
                                  Axis::chebyshev({"c"}, 0.0, 1.0, 20)};
  const auto smooth = [](std::span<const double> x) { return 1.0 / (1.0 + x[0] + 2.0 * x[1] * x[2]); };
  const SeparatedFunction f = separate(smooth, axes, {.tolerance = 1e-7});
  CHECK(f.tolerance_met);
  CHECK(static_cast<double>(f.evaluations) < f.grid_size);
  double largest = 0.0;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      for (int l = 0; l < 20; ++l) {
        const std::vector<int> index = {i, j, l};
        const std::vector<double> x = {axes[0].nodes()[i], axes[1].nodes()[j], axes[2].nodes()[l]};
        largest = std::max(largest, std::abs(f.tensor.entry(index) - smooth(x)));
      }
    }
  }
  CHECK(largest < 3e-7);
  const SeparatedFunction poor = separate(smooth, axes, {.tolerance = 1e-9, .max_rank = 2});
  CHECK_FALSE(poor.tolerance_met);
  CHECK_THAT(poor.message, Contains("> 1e-09 at 500 check nodes"));
  const SeparatedFunction zero = separate([](std::span<const double>) { return 0.0; }, axes);
  CHECK(zero.tolerance_met);
  CHECK(zero.tensor.rank() == 0);
  CHECK_THROWS_WITH(separate([](std::span<const double> x) { return std::sqrt(x[0] - 2.0); }, axes),
                    Contains("f is") && Contains("nan at a ="));
}

TEST_CASE("a problem at a point of its parameters has the solution there of the whole one") {
  // -k u'' = s on (0,1), u(0) = g, u(1) = 0: u = g (1 - x) + s x (1 - x)/(2 k).
  const Axis x = Axis::legendre({"x", "1", kSpace}, 0.0, 1.0, 5);
  const Axis k = Axis::chebyshev({"k"}, 0.5, 2.0, 5);
  const Axis s = Axis::chebyshev({"s"}, 1.0, 2.0, 3);
  const Axis g = Axis::chebyshev({"g", "1", AxisRole::boundary}, -1.0, 1.0, 3);
  ParametricProblem problem({x, k, s, g});
  problem.add_term({{"x", ModeOperator::sparse(x.stiffness())}, {"k", ModeOperator::diagonal(k.nodes())}},
                   2.0);
  problem.add_source({{"s", s.nodes()}}, 2.0);
  problem.know("x", {0, x.size() - 1});
  problem.add_to_lift({{"x", 1.0 - x.nodes().array()}, {"g", g.nodes()}});
  // Between the nodes of all of them.
  const SeparatedField u = solved(problem.at({{"k", 0.83}, {"s", 1.21}, {"g", -0.37}}));
  REQUIRE(u.axis_count() == 1);
  for (const double place : {0.0, 0.2, 0.7, 1.0}) {
    const double exact = -0.37 * (1.0 - place) + 1.21 * place * (1.0 - place) / (2.0 * 0.83);
    CHECK(std::abs(u(std::vector{place})[0] - exact) < 1e-9);
  }
  // Some of them may be left.
  const SeparatedField over_s = solved(problem.at({{"k", 1.0}, {"g", 1.0}}));
  CHECK(std::abs(over_s(std::vector{0.5, 1.7})[0] - (0.5 + 1.7 / 8.0)) < 1e-9);
  CHECK_THROWS_WITH(problem.at({{"x", 0.5}}), Contains("axis \"x\", which is weak"));
  CHECK_THROWS_WITH(problem.at({{"kk", 0.5}}), Contains("no axis \"kk\""));
  CHECK_THROWS_WITH(problem.at({{"k", 3.0}}), Contains("k is 3"));
  ParametricProblem coupled({x, k});
  coupled.add_term({{"k", ModeOperator::sparse(k.derivative())}});
  CHECK_THROWS_WITH(coupled.at({{"k", 1.0}}), Contains("axis \"k\" is no diagonal"));
}
