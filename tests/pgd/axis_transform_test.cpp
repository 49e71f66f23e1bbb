// Axes whose elements are polynomials in s = log x, -1/x or sqrt x.

#include <cmath>
#include <functional>
#include <limits>

#include <catch2/catch.hpp>

#include "axis_values.h"
#include "samara/base/errors.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/axes/axis_forms.h"
#include "samara/pgd/tensors/random.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

using Function = std::function<double(double)>;

Axis::Label label(Transform transform) {
  return {"x", "m", AxisRole::parameter, transform};
}

const std::vector<Transform> kAllTransforms = {Transform::none, Transform::logarithm, Transform::reciprocal,
                                               Transform::square_root};

/// All kinds with elements over [lower, upper].
std::vector<Axis> kinds(Transform transform, double lower, double upper) {
  const Axis::Label l = label(transform);
  return {Axis::p1(l, lower, upper, 7), Axis::p2(l, lower, upper, 4), Axis::chebyshev(l, lower, upper, 9),
          Axis::legendre(l, lower, upper, 9), Axis::radau(l, lower, upper, 3, 3)};
}

double s_of(Transform transform, double x) {
  switch (transform) {
    case Transform::none:
      return x;
    case Transform::logarithm:
      return std::log(x);
    case Transform::reciprocal:
      return -1.0 / x;
    case Transform::square_root:
      return std::sqrt(x);
  }
  throw samara::Error("no such transform");
}

/// Integral of s^p over dx from a to b, by hand.
double integral_of_power(Transform transform, int p, double a, double b) {
  switch (transform) {
    case Transform::none:
      return (std::pow(b, p + 1) - std::pow(a, p + 1)) / (p + 1);
    case Transform::logarithm: {
      const auto primitive = [p](double x) {
        const double s = std::log(x);
        return p == 0 ? x : p == 1 ? x * (s - 1.0) : x * (s * s - 2.0 * s + 2.0);
      };
      return primitive(b) - primitive(a);
    }
    case Transform::reciprocal:
      return p == 0 ? b - a : p == 1 ? -std::log(b / a) : 1.0 / a - 1.0 / b;
    case Transform::square_root:
      return (std::pow(b, 0.5 * p + 1.0) - std::pow(a, 0.5 * p + 1.0)) / (0.5 * p + 1.0);
  }
  throw samara::Error("no such transform");
}

/// Integral of (ds/dx)^2 over dx.
double integral_of_slope2(Transform transform, double a, double b) {
  switch (transform) {
    case Transform::none:
      return b - a;
    case Transform::logarithm:
      return 1.0 / a - 1.0 / b;
    case Transform::reciprocal:
      return (std::pow(a, -3.0) - std::pow(b, -3.0)) / 3.0;
    case Transform::square_root:
      return 0.25 * std::log(b / a);
  }
  throw samara::Error("no such transform");
}

/// Largest relative error of interpolating f at points spread evenly in log x.
double relative_error(const Axis& axis, const Function& f) {
  const Eigen::VectorXd u = axis.nodes().unaryExpr(f);
  double error = 0.0;
  for (int i = 0; i <= 1000; ++i) {
    const double x = std::min(axis.upper(), axis.lower() * std::pow(axis.upper() / axis.lower(), i / 1000.0));
    error = std::max(error, std::abs(evaluate(axis, u, x) / f(x) - 1.0));
  }
  return error;
}

}  // namespace

TEST_CASE("under every transform, weak forms with the coefficient 1 are the axis's own, over decades too") {
  const AxisFunction one = [](double) { return 1.0; };
  for (const Transform transform : kAllTransforms) {
    for (const int degree : {1, 8}) {
      const Axis axis =
          Axis::of_elements(label(transform), Basis::chebyshev, Eigen::Vector2d(1e-3, 1.0), degree);
      CAPTURE(to_string(transform), degree);
      CHECK((weighted_mass(axis, one) - axis.mass()).norm() <= 1e-12 * axis.mass().norm());
      CHECK((weighted_stiffness(axis, one) - axis.stiffness()).norm() <= 1e-12 * axis.stiffness().norm());
      CHECK((load_vector(axis, one) - axis.weights()).norm() <= 1e-12 * axis.weights().norm());
    }
  }
}

TEST_CASE("mass, gradient, stiffness and weights under every transform are integrals over dx") {
  for (const Transform transform : kAllTransforms) {
    for (const auto& [a, b] : {std::pair(0.5, 3.0), {1e-3, 2.0}, {1e6, 1e6 + 1.0}}) {
      for (const Axis& axis : kinds(transform, a, b)) {
        CAPTURE(to_string(transform), to_string(axis.basis()), a, b);
        const Eigen::VectorXd ones = Eigen::VectorXd::Ones(axis.size());
        const Eigen::VectorXd s = axis.nodes().unaryExpr([&](double x) { return s_of(transform, x); });
        const auto integral = [&](int p) { return integral_of_power(transform, p, a, b); };
        // The narrow interval far out loses six digits in the reference formulas, and more for the square.
        const double digits = a > 1.0 ? 1e-7 : 1e-12;
        CHECK(axis.weights().sum() == Approx(b - a).epsilon(1e-13));
        CHECK((axis.mass() * ones - axis.weights()).norm() < 1e-13 * (b - a));
        CHECK(axis.weights().dot(s) == Approx(integral(1)).epsilon(digits));
        if (a < 1.0) CHECK(s.dot(axis.mass() * s) == Approx(integral(2)).epsilon(digits));
        const double rise = s_of(transform, b) - s_of(transform, a);
        CHECK(ones.dot(axis.gradient() * s) == Approx(rise).epsilon(digits));
        if (a < 1.0) {
          CHECK(s.dot(axis.stiffness() * s) == Approx(integral_of_slope2(transform, a, b)).epsilon(1e-11));
        }
      }
    }
  }
}

TEST_CASE("the square root from 0 integrates, interpolates, and has no stiffness") {
  const Axis axis = Axis::legendre(label(Transform::square_root), 0.0, 4.0, 8);
  CHECK(axis.nodes()[0] == 0.0);
  CHECK(axis.weights().sum() == Approx(4.0).epsilon(1e-14));
  const Eigen::VectorXd root = axis.nodes().cwiseSqrt();
  CHECK(axis.weights().dot(root) == Approx(2.0 / 3.0 * 8.0).epsilon(1e-13));
  CHECK(root.dot(axis.mass() * root) == Approx(8.0).epsilon(1e-13));
  CHECK(evaluate(axis, root, 1e-6) == Approx(1e-3).epsilon(1e-10));
  CHECK(evaluate(axis, root, 1e-6, true) == Approx(500.0).epsilon(1e-10));
  CHECK_FALSE(std::isfinite(evaluate(axis, root, 0.0, true)));
  CHECK_NOTHROW(axis.gradient());
  CHECK_THROWS_WITH(axis.stiffness(), Contains("begins at 0 with the transform \"square_root\""));
  CHECK_THROWS_WITH(axis.derivative(), Contains("no derivative"));
}

TEST_CASE("under every transform a polynomial in s is represented exactly, with its derivative by x") {
  Random random(1);
  for (const Transform transform : kAllTransforms) {
    for (const Axis& axis : kinds(transform, 0.2, 5.0)) {
      CAPTURE(to_string(transform), to_string(axis.basis()));
      const int p = axis.degree();
      const auto f = [&](double x) { return std::pow(s_of(transform, x) + 0.3, p); };
      const auto slope = [&](double x) {
        return p * std::pow(s_of(transform, x) + 0.3, p - 1) * transform_slope(transform, x);
      };
      const Eigen::VectorXd u = axis.nodes().unaryExpr(f);
      const double scale = u.cwiseAbs().maxCoeff();
      for (int i = 0; i < 100; ++i) {
        const double x = 0.2 + 4.8 * random.uniform();
        CHECK(std::abs(evaluate(axis, u, x) - f(x)) < 1e-13 * scale);
        CHECK(std::abs(evaluate(axis, u, x, true) - slope(x)) < 1e-11 * scale * p * p);
      }
      const Eigen::VectorXd slopes = axis.nodes().unaryExpr(slope);
      CHECK((axis.derivative() * u - slopes).norm() < 1e-11 * slopes.norm());
    }
  }
}

TEST_CASE("under every transform the stencil's derivative is that of its values") {
  Random random(2);
  for (const Transform transform : kAllTransforms) {
    for (const Axis& axis : kinds(transform, 0.5, 3.0)) {
      CAPTURE(to_string(transform), to_string(axis.basis()));
      const Eigen::VectorXd u = Eigen::VectorXd::NullaryExpr(axis.size(), [&] { return random.normal(); });
      for (int i = 0; i < 100; ++i) {
        const double x = 0.5 + 2.5 * random.uniform();
        constexpr double kStep = 1e-5;
        if (axis.element_of(x - kStep) != axis.element_of(x + kStep)) continue;
        const double difference =
            (evaluate(axis, u, x + kStep) - evaluate(axis, u, x - kStep)) / (2.0 * kStep);
        CHECK(evaluate(axis, u, x, true) == Approx(difference).epsilon(1e-5).margin(1e-4));
      }
    }
  }
}

TEST_CASE("under every transform nodes ascend between the ends and are hit exactly") {
  for (const Transform transform : kAllTransforms) {
    for (const auto& [a, b] : {std::pair(0.5, 3.0), {1e-9, 1e9}, {1e6, 1e6 + 1.0}}) {
      for (const Axis& axis : kinds(transform, a, b)) {
        CAPTURE(to_string(transform), to_string(axis.basis()), a, b);
        CHECK(axis.lower() == a);
        CHECK(axis.upper() == b);
        CHECK(axis.nodes()[0] == a);
        CHECK(axis.nodes()[axis.size() - 1] == b);
        InterpolationStencil stencil = axis.make_stencil();
        for (int i = 0; i < axis.size(); ++i) {
          if (i > 0) CHECK(axis.nodes()[i] > axis.nodes()[i - 1]);
          axis.interpolate(axis.nodes()[i], stencil, false);
          // The rounding of a node far out on a narrow interval, magnified by the slopes of the basis.
          const double rounding = 1e-14 + 100.0 * std::numeric_limits<double>::epsilon() * b / (b - a);
          CHECK(stencil.value.maxCoeff() == Approx(1.0).epsilon(rounding));
          CHECK(stencil.value.sum() == Approx(1.0).epsilon(1e-13));
        }
      }
    }
  }
}

TEST_CASE("the gradient integrates by parts under every transform") {
  for (const Transform transform : kAllTransforms) {
    for (const Axis& axis : kinds(transform, 0.1, 3.0)) {
      CAPTURE(to_string(transform), to_string(axis.basis()));
      const Eigen::MatrixXd gradient = axis.gradient();
      Eigen::MatrixXd border = Eigen::MatrixXd::Zero(axis.size(), axis.size());
      border(0, 0) = -1.0;
      border(axis.size() - 1, axis.size() - 1) = 1.0;
      CHECK((gradient + gradient.transpose() - border).norm() < 1e-12);
    }
  }
}

TEST_CASE("a log axis resolves 1/x over four decades where one without transform does not") {
  const auto inverse = [](double x) { return 1.0 / x; };
  const auto error = [&](Transform transform, int count) {
    return relative_error(Axis::chebyshev(label(transform), 1e-2, 1e2, count), inverse);
  };
  CHECK(error(Transform::logarithm, 25) < 1e-11);
  CHECK(error(Transform::none, 100) > 0.1);
  // In 1/x itself, two nodes do.
  CHECK(error(Transform::reciprocal, 2) < 1e-12);
  // Every four nodes more gain: geometric convergence.
  CHECK(error(Transform::logarithm, 20) < 0.1 * error(Transform::logarithm, 16));
}

TEST_CASE("finite elements equal in s keep their order under a transform") {
  const auto f = [](double x) { return 1.0 / (1.0 + x); };
  const auto rate = [&](const auto& axis) {
    return std::log2(relative_error(axis(64), f) / relative_error(axis(128), f));
  };
  for (const Transform transform : {Transform::logarithm, Transform::reciprocal, Transform::square_root}) {
    CAPTURE(to_string(transform));
    CHECK(rate([&](int n) { return Axis::p1(label(transform), 0.5, 5.0, n + 1); }) ==
          Approx(2.0).margin(0.2));
    CHECK(rate([&](int n) { return Axis::p2(label(transform), 0.5, 5.0, n); }) == Approx(3.0).margin(0.25));
  }
}

TEST_CASE("an interval that leaves the domain of its transform is refused by name") {
  const auto make = [](Transform transform, double lower) {
    return Axis::chebyshev(label(transform), lower, 2.0, 5);
  };
  CHECK_THROWS_WITH(make(Transform::logarithm, 0.0),
                    Contains("axis \"x\" begins at 0 with the transform \"log\", expected more than 0"));
  CHECK_THROWS_WITH(make(Transform::reciprocal, -1.0),
                    Contains("begins at -1 with the transform \"reciprocal\""));
  CHECK_THROWS_WITH(make(Transform::square_root, -1e-9), Contains("expected at least 0"));
  CHECK_THROWS_AS(Axis::p1(label(Transform::logarithm), -1.0, 1.0, 5), samara::ArgumentError);
  CHECK_THROWS_AS(Axis::p2(label(Transform::logarithm), Eigen::Vector2d(0.0, 1.0)), samara::ArgumentError);
  CHECK_THROWS_AS(Axis::radau(label(Transform::reciprocal), 0.0, 1.0, 2, 3), samara::ArgumentError);
  CHECK_NOTHROW(make(Transform::square_root, 0.0));
}

TEST_CASE("names of transforms survive the way to text and back") {
  for (const Transform transform : kAllTransforms)
    CHECK(transform_from_string(to_string(transform)) == transform);
  CHECK(to_string(Transform::logarithm) == "log");
  CHECK_THROWS_WITH(transform_from_string("squareroot"), Contains("did you mean \"square_root\"?"));
}
