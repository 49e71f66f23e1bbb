#include "samara/pgd/sampling/leja.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/axes/lagrange.h"

using namespace samara::pgd;
using Catch::Contains;

TEST_CASE("a longer Leja sequence begins with the shorter one, and its points differ") {
  const Eigen::VectorXd all = leja_points(kMostLejaPoints);
  CHECK(leja_points(7) == all.head(7));
  CHECK(all.cwiseAbs().maxCoeff() == 1.0);
  Eigen::VectorXd sorted = all;
  std::sort(sorted.begin(), sorted.end());
  // Chebyshev's 128 points are 3e-4 apart at the ends; Leja's, of the same density, may be a few times
  // closer.
  CHECK((sorted.tail(kMostLejaPoints - 1) - sorted.head(kMostLejaPoints - 1)).minCoeff() > 5e-5);
}

TEST_CASE("the fourth and fifth Leja points are where the products of distances are largest") {
  // |x (x^2 - 1)| is largest at x = 1/sqrt(3), of two equal maxima the positive one.
  CHECK(leja_points(4)[3] == Approx(1.0 / std::sqrt(3.0)).epsilon(1e-12));
  // Then |x (x^2 - 1)(x - 1/sqrt(3))|: among the grid's points none is larger.
  const Eigen::VectorXd points = leja_points(5);
  const auto product = [&](double x) { return (x - points.head(4).array()).abs().prod(); };
  double largest = 0.0;
  for (double x = -1.0; x <= 1.0; x += 1e-4) largest = std::max(largest, product(x));
  CHECK(product(points[4]) >= largest * (1.0 - 1e-12));
}

TEST_CASE("interpolation on Leja points converges geometrically and stays well conditioned") {
  // Lebesgue constants of Leja points grow slower than their number.
  for (const int n : {5, 10, 20, 40, 80, 128}) {
    const LagrangeBasis basis(leja_points(n));
    Eigen::VectorXd values(n);
    double lebesgue = 0.0;
    for (double x = -1.0; x <= 1.0; x += 1e-3) {
      basis.values(x, values);
      lebesgue = std::max(lebesgue, values.lpNorm<1>());
    }
    CHECK(lebesgue < n);
  }
  // 1/(x + 1.25) has its pole at the sum of the semi-axes 2 of the Bernstein ellipse: error about 2^-n.
  double before = 4.0;  // the largest value of f
  for (const int n : {8, 16, 24, 32}) {
    const LagrangeBasis basis(leja_points(n));
    const Eigen::VectorXd f = (basis.nodes().array() + 1.25).inverse();
    Eigen::VectorXd values(n);
    double error = 0.0;
    for (double x = -1.0; x <= 1.0; x += 1e-2) {
      basis.values(x, values);
      error = std::max(error, std::abs(values.dot(f) - 1.0 / (x + 1.25)));
    }
    CHECK(error < before / 100.0);  // 2^-8 = 1/256
    before = error;
  }
}

TEST_CASE("a number of Leja points that there is not is refused") {
  CHECK_THROWS_WITH(leja_points(0), Contains("Leja points is 0; 1 to 128"));
  CHECK_THROWS_WITH(leja_points(kMostLejaPoints + 1), Contains("Leja points is 129"));
}
