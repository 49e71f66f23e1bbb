#include "samara/models/integrators/linear_system.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::models;
using Catch::Matchers::Contains;

namespace {

using Sparse = Eigen::SparseMatrix<double>;

Sparse sparse(const Eigen::MatrixXd& matrix) {
  return matrix.sparseView();
}

/// Second differences on n inner points of the unit interval.
Sparse second_differences(int n) {
  Sparse matrix(n, n);
  const double h = 1.0 / (n + 1);
  for (int i = 0; i < n; ++i) {
    matrix.insert(i, i) = 2.0 / (h * h);
    if (i > 0) matrix.insert(i, i - 1) = -1.0 / (h * h);
    if (i + 1 < n) matrix.insert(i, i + 1) = -1.0 / (h * h);
  }
  matrix.makeCompressed();
  return matrix;
}

}  // namespace

TEST_CASE("a stiff linear system decays as its eigenvector does") {
  // Second differences have the eigenvector sin(pi x_i) with (2 - 2 cos(pi h))/h^2; the fastest is 4/h^2 = 1.6e5.
  constexpr int n = 199;
  const double h = 1.0 / (n + 1);
  Sparse mass(n, n);
  mass.setIdentity();
  mass *= 3.0;
  Eigen::VectorXd start(n);
  for (int i = 0; i < n; ++i) start[i] = std::sin(std::numbers::pi * (i + 1) * h);
  const double rate = (2.0 - 2.0 * std::cos(std::numbers::pi * h)) / (h * h) / 3.0;
  const std::vector<double> times = {0.0, 0.01, 0.1, 0.7};
  const Eigen::MatrixXd u = integrate_linear({mass, second_differences(n), {}}, start, times);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const Eigen::VectorXd exact = std::exp(-rate * times[i]) * start;
    CHECK((u.col(static_cast<Eigen::Index>(i)) - exact).cwiseAbs().maxCoeff() < 1e-8);
  }
}

TEST_CASE("an unsymmetric system with a load in time follows its exact solution") {
  // M u' + K u = f with u = (sin t, cos t): f = M (cos t, -sin t) + K (sin t, cos t).
  const Eigen::Matrix2d mass{{2.0, 1.0}, {0.0, 1.0}}, stiffness{{1.0, 3.0}, {-2.0, 0.5}};
  const auto load = [&](double t, Eigen::Ref<Eigen::VectorXd> f) {
    f = mass * Eigen::Vector2d(std::cos(t), -std::sin(t)) +
        stiffness * Eigen::Vector2d(std::sin(t), std::cos(t));
  };
  const std::vector<double> times = {0.0, 0.5, 3.0};
  const Eigen::MatrixXd u =
      integrate_linear({sparse(mass), sparse(stiffness), load}, Eigen::Vector2d(0.0, 1.0), times);
  CHECK((u.col(1) - Eigen::Vector2d(std::sin(0.5), std::cos(0.5))).norm() < 1e-8);
  CHECK((u.col(2) - Eigen::Vector2d(std::sin(3.0), std::cos(3.0))).norm() < 1e-8);
}

TEST_CASE("what cannot be integrated is said in one sentence") {
  const Sparse one = sparse(Eigen::MatrixXd::Identity(2, 2)), zero = sparse(Eigen::MatrixXd::Zero(2, 2));
  const Eigen::Vector2d start(1.0, 2.0);
  const std::vector<double> times = {0.0, 1.0}, back = {1.0, 0.0};
  CHECK_THROWS_AS(integrate_linear({zero, one, {}}, start, times), samara::NoResultError);
  CHECK_THROWS_WITH(integrate_linear({one, one, {}}, Eigen::VectorXd::Ones(3), times), Contains("2 x 2"));
  CHECK_THROWS_WITH(integrate_linear({one, one, {}}, start, back), Contains("times[1]"));
  CHECK_THROWS_WITH(integrate_linear({one, one, {}}, start, {}), Contains("no times"));
  CHECK_THROWS_WITH(integrate_linear({one, one, {}}, Eigen::Vector2d(1.0, NAN), times),
                    Contains("not finite"));
  CHECK_THROWS_WITH(integrate_linear({one, one, {}}, start, times, {.relative_tolerance = 0.0}),
                    Contains("relative_tolerance is 0"));
  const auto throwing = [](double, Eigen::Ref<Eigen::VectorXd>) { throw samara::ArgumentError("no load"); };
  CHECK_THROWS_WITH(integrate_linear({one, one, throwing}, start, times), Contains("no load"));
}
