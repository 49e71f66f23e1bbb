#include "samara/pgd/axes/axis.h"

#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/tensors/random.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

Axis make(Basis basis, double lower, double upper, int resolution) {
  switch (basis) {
    case Basis::p1:
      return Axis::p1({"x", "m"}, lower, upper, resolution + 1);
    case Basis::chebyshev:
      return Axis::chebyshev({"x", "m"}, lower, upper, resolution + 1);
    case Basis::radau:
      return Axis::radau({"x", "m"}, lower, upper, resolution, 3);
    case Basis::p2:
      return Axis::p2({"x", "m"}, lower, upper, resolution);
    case Basis::legendre:
      return Axis::legendre({"x", "m"}, lower, upper, resolution + 1);
    case Basis::fourier:
    case Basis::discrete:
    case Basis::imported:
      break;  // not made of elements: axis_kinds_test.cpp
  }
  throw samara::Error("no such basis");
}

const std::vector<Basis> kAll = {Basis::p1, Basis::chebyshev, Basis::radau, Basis::p2, Basis::legendre};

/// Largest interpolation error of exp over random points of [0, 2].
double interpolation_error(const Axis& axis, bool derivative) {
  const Eigen::VectorXd values = axis.nodes().array().exp();
  InterpolationStencil stencil = axis.make_stencil();
  Random random(3);
  double error = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double x = 2.0 * random.uniform();
    axis.interpolate(x, stencil, true);
    const auto& weights = derivative ? stencil.derivative : stencil.value;
    error = std::max(error,
                     std::abs(weights.dot(values.segment(stencil.first, axis.stencil_size())) - std::exp(x)));
  }
  return error;
}

}  // namespace

TEST_CASE("matrices of every axis kind integrate and differentiate polynomials of its degree exactly") {
  for (const Basis basis : kAll) {
    const Axis axis = make(basis, -1.0, 2.5, 4);
    CAPTURE(to_string(basis));
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(axis.size());
    const Eigen::VectorXd& x = axis.nodes();
    // Integrals over [-1, 2.5]: 1, x^2 and the pairings of x with 1 and itself.
    CHECK(axis.weights().sum() == Approx(3.5));
    CHECK(ones.dot(axis.mass() * ones) == Approx(3.5));
    CHECK(x.dot(axis.mass() * x) == Approx((2.5 * 2.5 * 2.5 + 1.0) / 3.0));
    CHECK(x.dot(axis.gradient() * x) == Approx((2.5 * 2.5 - 1.0) / 2.0));
    CHECK(x.dot(axis.stiffness() * x) == Approx(3.5));
    CHECK((axis.derivative() * x - ones).norm() < 1e-12 * axis.size());
  }
}

TEST_CASE("mass and stiffness are symmetric and the gradient integrates by parts") {
  for (const Basis basis : kAll) {
    const Axis axis = make(basis, 0.0, 2.0, 5);
    CAPTURE(to_string(basis));
    const Eigen::MatrixXd mass = axis.mass();
    const Eigen::MatrixXd gradient = axis.gradient();
    Eigen::MatrixXd border = Eigen::MatrixXd::Zero(axis.size(), axis.size());
    border(0, 0) = -1.0;
    border(axis.size() - 1, axis.size() - 1) = 1.0;
    CHECK((mass - mass.transpose()).norm() < 1e-14);
    CHECK((gradient + gradient.transpose() - border).norm() < 1e-13);
  }
}

TEST_CASE("interpolation converges with the order of the axis kind") {
  const auto rate = [](Basis basis, bool derivative) {
    return std::log2(interpolation_error(make(basis, 0.0, 2.0, 8), derivative) /
                     interpolation_error(make(basis, 0.0, 2.0, 16), derivative));
  };
  CHECK(rate(Basis::p1, false) == Approx(2.0).margin(0.1));
  CHECK(rate(Basis::p1, true) == Approx(1.0).margin(0.1));
  CHECK(rate(Basis::p2, false) == Approx(3.0).margin(0.1));
  CHECK(rate(Basis::p2, true) == Approx(2.0).margin(0.1));
  CHECK(rate(Basis::radau, false) == Approx(4.0).margin(0.15));  // degree 3
  CHECK(rate(Basis::radau, true) == Approx(3.0).margin(0.15));
}

TEST_CASE("Chebyshev and Legendre interpolation of an entire function converge faster than any power") {
  for (const Basis basis : {Basis::chebyshev, Basis::legendre}) {
    CAPTURE(to_string(basis));
    CHECK(interpolation_error(make(basis, 0.0, 2.0, 8), false) < 1e-7);
    CHECK(interpolation_error(make(basis, 0.0, 2.0, 16), false) < 1e-13);
    CHECK(interpolation_error(make(basis, 0.0, 2.0, 16), true) < 1e-12);
  }
}

TEST_CASE("Radau collocation solves u' = -u with order 2s - 1 at the ends of its elements") {
  for (int s = 1; s <= 3; ++s) {
    const auto error = [s](int elements) {
      const Axis axis = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, elements, s);
      const int n = axis.size();
      const Eigen::MatrixXd d = Eigen::MatrixXd(axis.derivative()) + Eigen::MatrixXd::Identity(n, n);
      // u(0) = 1 is known: its column goes to the right-hand side.
      const Eigen::VectorXd u =
          d.bottomRightCorner(n - 1, n - 1).lu().solve(-d.bottomLeftCorner(n - 1, 1)).col(0);
      return std::abs(u[n - 2] - std::exp(-1.0));
    };
    CAPTURE(s);
    CHECK(std::log2(error(4) / error(8)) == Approx(2.0 * s - 1.0).margin(0.25));
  }
}

TEST_CASE("a node is interpolated exactly and weights sum to one everywhere") {
  for (const Basis basis : kAll) {
    const Axis axis = make(basis, -0.3, 0.6, 6);
    InterpolationStencil stencil = axis.make_stencil();
    for (int i = 0; i < axis.size(); ++i) {
      axis.interpolate(axis.nodes()[i], stencil, false);
      CHECK(stencil.value.maxCoeff() == Approx(1.0).epsilon(1e-14));
    }
    for (const double x : {-0.3, -0.299999, 0.1, 0.45, 0.6}) {
      axis.interpolate(x, stencil, true);
      CHECK(stencil.value.sum() == Approx(1.0).epsilon(1e-14));
      CHECK(stencil.derivative.sum() == Approx(0.0).margin(1e-10));
    }
  }
}

TEST_CASE("an axis that is empty, reversed or not finite is refused by name") {
  CHECK_THROWS_WITH(Axis::chebyshev({"C_D"}, 2.0, 1.0, 8), Contains("\"C_D\"") && Contains("from 2 to 1"));
  CHECK_THROWS_WITH(Axis::chebyshev({"C_D"}, 1.0, 1.0, 8), Contains("increasing"));
  CHECK_THROWS_WITH(Axis::chebyshev({"C_D"}, 1.0, 2.0, 1), Contains("number of nodes is 1"));
  CHECK_THROWS_WITH(Axis::p1({"x"}, Eigen::VectorXd::Zero(1)), Contains("number of nodes is 1"));
  CHECK_THROWS_WITH(Axis::radau({"t"}, 0.0, 1.0, 0, 3), Contains("number of elements is 0"));
  CHECK_THROWS_WITH(Axis::radau({"t"}, 0.0, 1.0, 2, 0), Contains("degree of its elements is 0"));
  CHECK_THROWS_WITH(Axis::p1({"x"}, 0.0, std::numeric_limits<double>::quiet_NaN(), 4),
                    Contains("not finite"));
}

TEST_CASE("names of bases and roles survive the way to text and back") {
  for (const Basis basis : kAll) CHECK(basis_from_string(to_string(basis)) == basis);
  for (const Basis basis : {Basis::fourier, Basis::discrete, Basis::imported}) {
    CHECK(basis_from_string(to_string(basis)) == basis);
  }
  for (const AxisRole role :
       {AxisRole::time, AxisRole::space, AxisRole::parameter, AxisRole::initial, AxisRole::boundary}) {
    CHECK(role_from_string(to_string(role)) == role);
  }
  CHECK_THROWS_WITH(basis_from_string("chebishev"), Contains("did you mean \"chebyshev\"?"));
}
