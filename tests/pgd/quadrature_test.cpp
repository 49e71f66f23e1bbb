#include "samara/pgd/axes/quadrature.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::pgd;

namespace {
/// Integral of x^p over [-1, 1].
double monomial(int p) {
  return p % 2 == 1 ? 0.0 : 2.0 / (p + 1);
}

double apply(const QuadratureRule& rule, int p) {
  return rule.weights.dot(rule.nodes.array().pow(p).matrix());
}
}  // namespace

TEST_CASE("Gauss-Legendre rules integrate polynomials of degree 2n - 1 and no more") {
  for (int n = 1; n <= 12; ++n) {
    const QuadratureRule rule = gauss_legendre(n);
    for (int p = 0; p <= 2 * n - 1; ++p) CHECK(apply(rule, p) == Approx(monomial(p)).margin(1e-14));
    CHECK(std::abs(apply(rule, 2 * n) - monomial(2 * n)) > 1e-9);
  }
}

TEST_CASE("right Radau rules end at 1 and integrate polynomials of degree 2n - 2 and no more") {
  for (int n = 1; n <= 12; ++n) {
    const QuadratureRule rule = gauss_radau_right(n);
    CHECK(rule.nodes[n - 1] == 1.0);
    for (int p = 0; p <= 2 * n - 2; ++p) CHECK(apply(rule, p) == Approx(monomial(p)).margin(1e-14));
    CHECK(std::abs(apply(rule, 2 * n - 1) - monomial(2 * n - 1)) > 1e-9);
  }
}

TEST_CASE("the three-point Radau rule is the one of Radau IIA") {
  // Hairer and Wanner, Solving ODEs II, table IV.5.6: c = (4 -+ sqrt 6) / 10, 1 on [0, 1].
  const QuadratureRule rule = gauss_radau_right(3);
  CHECK(rule.nodes[0] == Approx(2 * (4 - std::sqrt(6.0)) / 10 - 1).epsilon(1e-14));
  CHECK(rule.nodes[1] == Approx(2 * (4 + std::sqrt(6.0)) / 10 - 1).epsilon(1e-14));
  CHECK(rule.weights[2] == Approx(2.0 / 9.0).epsilon(1e-14));
}

TEST_CASE("Chebyshev-Lobatto nodes are symmetric and hold both ends") {
  for (int n : {2, 5, 16}) {
    const Eigen::VectorXd nodes = chebyshev_lobatto_nodes(n);
    CHECK(nodes[0] == -1.0);
    CHECK(nodes[n - 1] == 1.0);
    CHECK((nodes + nodes.reverse()).cwiseAbs().maxCoeff() == 0.0);
  }
}

TEST_CASE("a rule without nodes is refused") {
  CHECK_THROWS_AS(gauss_legendre(0), samara::ArgumentError);
  CHECK_THROWS_AS(gauss_radau_right(0), samara::ArgumentError);
  CHECK_THROWS_AS(chebyshev_lobatto_nodes(1), samara::ArgumentError);
}
