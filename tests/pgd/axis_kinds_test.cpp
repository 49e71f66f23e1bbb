// Laws and rates of the continuous kinds of axes beyond those of axis_test.cpp: quadratic elements, spectral
// elements, Fourier.

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "axis_values.h"
#include "samara/base/errors.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/axes/quadrature.h"
#include "samara/pgd/tensors/random.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;
using std::numbers::pi;

namespace {

using Function = std::function<double(double)>;

Eigen::VectorXd at_nodes(const Axis& axis, const Function& f) {
  return axis.nodes().unaryExpr(f);
}

/// Largest difference between the nodal values `u` and a function over random points of the axis.
double largest_error(const Axis& axis, const Eigen::VectorXd& u, const Function& f, bool derivative = false) {
  Random random(5);
  double error = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double x = axis.lower() + axis.length() * random.uniform();
    error = std::max(error, std::abs(evaluate(axis, u, x, derivative) - f(x)));
  }
  return error;
}

/// -u'' = f with u = 0 at both ends of [0, 1], f interpolated: K u = M f at the inner nodes.
Eigen::VectorXd solve_boundary_value_problem(const Axis& axis, const Function& f) {
  const Eigen::Index inner = axis.size() - 2;
  const Eigen::MatrixXd stiffness = axis.stiffness();
  const Eigen::VectorXd load = axis.mass() * at_nodes(axis, f);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(axis.size());
  u.segment(1, inner) = stiffness.block(1, 1, inner, inner).lu().solve(load.segment(1, inner));
  return u;
}

/// The manufactured solution sin(pi x) e^x and its -u''.
double manufactured(double x) {
  return std::sin(pi * x) * std::exp(x);
}
double load(double x) {
  return std::exp(x) * ((pi * pi - 1.0) * std::sin(pi * x) - 2.0 * pi * std::cos(pi * x));
}
double boundary_value_error(const Axis& axis) {
  return largest_error(axis, solve_boundary_value_problem(axis, load), manufactured);
}

Eigen::VectorXd equal(int elements, double lower = 0.0, double upper = 1.0) {
  return Eigen::VectorXd::LinSpaced(elements + 1, lower, upper);
}

/// Axes of every kind that has derivatives, over [-0.5, 1.5].
std::vector<Axis> samples() {
  const Eigen::Vector4d uneven(-0.5, -0.2, 1.0, 1.5);
  return {Axis::p1({"x"}, -0.5, 1.5, 9),         Axis::p2({"x"}, uneven),
          Axis::p2({"x"}, -0.5, 1.5, 4),         Axis::legendre({"x"}, -0.5, 1.5, 12),
          Axis::legendre({"x"}, uneven, 5),      Axis::chebyshev({"x"}, uneven, 6),
          Axis::chebyshev({"x"}, -0.5, 1.5, 11), Axis::fourier({"x"}, -0.5, 1.5, 3),
          Axis::fourier({"x"}, -0.5, 1.5, 15)};
}

/// A real trigonometric polynomial of the given degree and period 2, with fixed coefficients.
double trigonometric(double x, int degree) {
  double sum = 0.3;
  for (int k = 1; k <= degree; ++k) sum += std::cos(pi * k * x + k * k) / k;
  return sum;
}
double trigonometric_slope(double x, int degree) {
  double sum = 0.0;
  for (int k = 1; k <= degree; ++k) sum -= pi * std::sin(pi * k * x + k * k);
  return sum;
}

}  // namespace

TEST_CASE("a two-point boundary value problem converges with order 2 on P1 and 3 on P2 elements") {
  const auto rate = [](const auto& axis) {
    return std::log2(boundary_value_error(axis(16)) / boundary_value_error(axis(32)));
  };
  CHECK(rate([](int n) { return Axis::p1({"x"}, 0.0, 1.0, n + 1); }) == Approx(2.0).margin(0.1));
  CHECK(rate([](int n) { return Axis::p2({"x"}, 0.0, 1.0, n); }) == Approx(3.0).margin(0.15));
  CHECK(rate([](int n) { return Axis::legendre({"x"}, equal(n / 4), 4); }) == Approx(5.0).margin(0.3));
  CHECK(rate([](int n) { return Axis::chebyshev({"x"}, equal(n / 4), 4); }) == Approx(5.0).margin(0.3));
}

TEST_CASE("a two-point boundary value problem converges faster than any power on spectral axes") {
  for (const auto factory : {+[](int n) { return Axis::legendre({"x"}, 0.0, 1.0, n); },
                             +[](int n) { return Axis::chebyshev({"x"}, 0.0, 1.0, n); }}) {
    // The solution is entire: every four nodes more gain at least a factor of a thousand.
    CHECK(boundary_value_error(factory(10)) < 1e-3 * boundary_value_error(factory(6)));
    CHECK(boundary_value_error(factory(14)) < 1e-3 * boundary_value_error(factory(10)));
    CHECK(boundary_value_error(factory(18)) < 1e-12);
  }
}

TEST_CASE("Fourier interpolation of an analytic periodic function converges geometrically") {
  const auto f = [](double x) { return std::exp(std::sin(pi * x)); };
  const auto error = [&](int n) {
    const Axis axis = Axis::fourier({"x"}, -0.5, 1.5, n);
    return largest_error(axis, at_nodes(axis, f), f);
  };
  CHECK(error(11) < 1e-2 * error(7));
  CHECK(error(15) < 1e-2 * error(11));
  CHECK(error(31) < 1e-13);
}

TEST_CASE("a periodic problem u - u'' = f is solved geometrically by the Fourier mass and stiffness") {
  const auto exact = [](double x) { return std::exp(std::sin(pi * x)); };
  const auto rhs = [&](double x) {
    const double s = std::sin(pi * x), c = std::cos(pi * x);
    return exact(x) * (1.0 - pi * pi * (c * c - s));
  };
  const auto error = [&](int n) {
    const Axis axis = Axis::fourier({"x"}, -0.5, 1.5, n);
    const Eigen::MatrixXd matrix = axis.mass() + axis.stiffness();
    return largest_error(axis, matrix.lu().solve(axis.mass() * at_nodes(axis, rhs)), exact);
  };
  CHECK(error(15) < 1e-2 * error(11));
  CHECK(error(31) < 1e-12);
}

TEST_CASE("Fourier matrices are exact for the trigonometric polynomials that the axis represents") {
  for (const int n : {3, 5, 9, 33}) {
    CAPTURE(n);
    const int degree = (n - 1) / 2;
    const Axis axis = Axis::fourier({"angle", "rad"}, -0.5, 1.5, n);
    const Eigen::VectorXd u = at_nodes(axis, [&](double x) { return trigonometric(x, degree); });
    const Eigen::VectorXd slope = at_nodes(axis, [&](double x) { return trigonometric_slope(x, degree); });
    double mass = 2.0 * 0.3 * 0.3;  // integrals over a period, by Parseval's equation
    for (int k = 1; k <= degree; ++k) mass += 1.0 / (k * k);
    const double round_off = 1e-14 * n * slope.norm();
    CHECK((axis.derivative() * u - slope).norm() < round_off);
    CHECK(u.dot(axis.mass() * u) == Approx(mass).epsilon(1e-13));
    CHECK(u.dot(axis.stiffness() * u) == Approx(pi * pi * degree).epsilon(1e-12));
    CHECK(std::abs(u.dot(axis.gradient() * u)) < round_off * u.norm());
    CHECK((axis.gradient() * u - axis.mass() * slope).norm() < round_off);
    const auto f = [&](double x) { return trigonometric(x, degree); };
    const auto df = [&](double x) { return trigonometric_slope(x, degree); };
    CHECK(largest_error(axis, u, f) < round_off);
    CHECK(largest_error(axis, u, df, true) < round_off * n);
  }
}

TEST_CASE("Fourier interpolation is periodic, and exact at and beside its nodes") {
  const Axis axis = Axis::fourier({"angle", "rad"}, 0.1, 0.1 + 2.0 * pi, 21);
  CHECK(axis.nodes()[0] == 0.1);
  CHECK(axis.nodes()[20] < axis.upper() - 0.29);
  const Eigen::VectorXd u = at_nodes(axis, [](double x) { return std::cos(3.0 * x) + std::sin(10.0 * x); });
  for (Eigen::Index i = 0; i < axis.size(); ++i) {
    const double x = axis.nodes()[i];
    CHECK(evaluate(axis, u, x) == u[i]);
    CHECK(evaluate(axis, u, std::nextafter(x, 10.0)) == Approx(u[i]).margin(1e-13));
    CHECK(evaluate(axis, u, x + axis.length()) == Approx(u[i]).margin(1e-13));
    CHECK(evaluate(axis, u, x - 3.0 * axis.length()) == Approx(u[i]).margin(1e-12));
  }
  CHECK(evaluate(axis, u, axis.upper()) == Approx(u[0]).margin(1e-13));
  CHECK(evaluate(axis, u, axis.upper(), true) == Approx(evaluate(axis, u, axis.lower(), true)));
  CHECK(evaluate(axis, u, std::nextafter(axis.lower(), 0.0)) == Approx(u[0]).margin(1e-13));
  CHECK(axis.contains(axis.upper()));
  CHECK_FALSE(axis.contains(axis.upper() + 1e-9));
}

TEST_CASE("weights of every kind sum to the length and stencils to one") {
  for (const Axis& axis : samples()) {
    CAPTURE(to_string(axis.basis()), axis.size());
    CHECK(axis.weights().sum() == Approx(2.0).epsilon(1e-13));
    CHECK(axis.measure() == 2.0);
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(axis.size());
    CHECK((axis.mass() * ones - axis.weights()).norm() < 1e-14);
    CHECK(largest_error(axis, ones, [](double) { return 1.0; }) < 1e-14);
    CHECK(largest_error(
              axis, ones, [](double) { return 0.0; }, true) < 1e-11);
  }
}

TEST_CASE("mass, gradient and stiffness of every kind are the integrals of stencils") {
  // Gauss's rule on many short panels, by the stencils: a second route to all matrices.
  const QuadratureRule rule = gauss_legendre(20);
  for (const Axis& axis : samples()) {
    CAPTURE(to_string(axis.basis()), axis.size());
    const int n = axis.size();
    Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(n, n), gradient = mass, stiffness = mass;
    InterpolationStencil stencil = axis.make_stencil();
    for (int panel = 0; panel < 40; ++panel) {
      for (Eigen::Index q = 0; q < rule.nodes.size(); ++q) {
        axis.interpolate(-0.5 + 0.05 * (panel + 0.5 + 0.5 * rule.nodes[q]), stencil, true);
        const Eigen::Index size = axis.stencil_size();
        const double w = 0.025 * rule.weights[q];
        const Eigen::Index i = stencil.first;
        mass.block(i, i, size, size) += w * stencil.value * stencil.value.transpose();
        gradient.block(i, i, size, size) += w * stencil.value * stencil.derivative.transpose();
        stiffness.block(i, i, size, size) += w * stencil.derivative * stencil.derivative.transpose();
      }
    }
    CHECK((mass - Eigen::MatrixXd(axis.mass())).norm() < 1e-13);
    CHECK((gradient - Eigen::MatrixXd(axis.gradient())).norm() < 1e-11);
    CHECK((stiffness - Eigen::MatrixXd(axis.stiffness())).norm() < 1e-10 * stiffness.norm());
  }
}

TEST_CASE("the derivative of every stencil is that of its values") {
  Random random(9);
  for (const Axis& axis : samples()) {
    CAPTURE(to_string(axis.basis()), axis.size());
    const Eigen::VectorXd u = Eigen::VectorXd::NullaryExpr(axis.size(), [&] { return random.normal(); });
    for (int i = 0; i < 200; ++i) {
      const double x = axis.lower() + axis.length() * random.uniform();
      constexpr double kStep = 1e-5;
      const bool at_border = axis.element_of(x - kStep) != axis.element_of(x + kStep);
      if (at_border) continue;
      const double difference = (evaluate(axis, u, x + kStep) - evaluate(axis, u, x - kStep)) / (2.0 * kStep);
      // Truncation is h^2 u''' / 6 with u''' up to (2 n^2)^3 at the ends; rounding eps / h.
      CHECK(evaluate(axis, u, x, true) == Approx(difference).epsilon(1e-5).margin(1e-3));
    }
  }
}

TEST_CASE("the gradient of every kind integrates by parts, up to the ends where there are any") {
  for (const Axis& axis : samples()) {
    CAPTURE(to_string(axis.basis()), axis.size());
    const Eigen::MatrixXd gradient = axis.gradient();
    Eigen::MatrixXd border = Eigen::MatrixXd::Zero(axis.size(), axis.size());
    if (axis.has_elements()) {
      border(0, 0) = -1.0;
      border(axis.size() - 1, axis.size() - 1) = 1.0;
    }
    CHECK((gradient + gradient.transpose() - border).norm() < 1e-12);
  }
}

TEST_CASE("the derivative matrix is exact on the polynomials of the elements") {
  for (const Axis& axis : samples()) {
    if (!axis.has_elements()) continue;
    CAPTURE(to_string(axis.basis()), axis.size());
    const int p = axis.degree();
    const Eigen::VectorXd u = at_nodes(axis, [p](double x) { return std::pow(x, p); });
    const Eigen::VectorXd slope = at_nodes(axis, [p](double x) { return p * std::pow(x, p - 1); });
    CHECK((axis.derivative() * u - slope).norm() < 1e-11 * slope.norm());
  }
}

TEST_CASE("Legendre nodes of a quadratic element are those of Simpson's rule, of a cubic +-1/sqrt 5") {
  CHECK((legendre_lobatto_nodes(3) - Eigen::Vector3d(-1.0, 0.0, 1.0)).norm() == 0.0);
  const Eigen::VectorXd cubic = legendre_lobatto_nodes(4);
  CHECK(cubic[1] == Approx(-1.0 / std::sqrt(5.0)).epsilon(1e-15));
  // Lobatto's rule with 2, 3, .. nodes has positive weights that are exact to degree 2n - 3: the weights of
  // the basis integrate the square of the polynomial one degree below.
  for (const int n : {2, 3, 7, 30}) {
    const Axis axis = Axis::legendre({"x"}, -1.0, 1.0, n);
    CHECK(axis.weights().minCoeff() > 0.0);
    const double integral =
        axis.weights().dot(at_nodes(axis, [n](double x) { return std::pow(x, 2 * n - 4); }));
    CHECK(integral == Approx(2.0 / (2 * n - 3)).epsilon(1e-12));
  }
}

TEST_CASE("one spectral element between two borders is the axis of one interval") {
  const Eigen::Vector2d ends(0.5, 3.0);
  CHECK(Axis::chebyshev({"x"}, ends, 7).nodes() == Axis::chebyshev({"x"}, 0.5, 3.0, 8).nodes());
  CHECK(Axis::legendre({"x"}, ends, 7).nodes() == Axis::legendre({"x"}, 0.5, 3.0, 8).nodes());
  CHECK(Axis::p2({"x"}, ends).nodes() == Axis::p2({"x"}, 0.5, 3.0, 1).nodes());
}

TEST_CASE("an axis without elements says so instead of naming a degree") {
  const Axis axis = Axis::fourier({"angle", "rad"}, 0.0, 1.0, 5);
  CHECK_FALSE(axis.has_elements());
  CHECK(axis.elements() == 0);
  CHECK(axis.borders().size() == 0);
  CHECK(axis.element_of(0.7) == 0);
  CHECK_THROWS_WITH(axis.degree(), Contains("\"angle\" is fourier and has no elements"));
  CHECK_THROWS_WITH(axis.element_basis(), Contains("no elements"));
}

TEST_CASE("arguments that make no quadratic, spectral or Fourier axis are refused by name") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(Axis::p2({"x"}, Eigen::VectorXd::Zero(1)),
                    Contains("axis \"x\": the number of nodes is 1"));
  CHECK_THROWS_WITH(Axis::p2({"x"}, 0.0, 1.0, 0), Contains("number of elements is 0"));
  CHECK_THROWS_WITH(Axis::p2({"x"}, Eigen::Vector3d(0.0, 2.0, 1.0)), Contains("from 2 to 1"));
  CHECK_THROWS_WITH(Axis::legendre({"x"}, 0.0, 1.0, 1), Contains("number of nodes is 1"));
  CHECK_THROWS_WITH(Axis::legendre({"x"}, 0.0, kNan, 5), Contains("not finite"));
  CHECK_THROWS_WITH(Axis::legendre({"x"}, equal(2), 0), Contains("degree of its elements is 0"));
  CHECK_THROWS_WITH(Axis::chebyshev({"x"}, equal(2), -1), Contains("degree of its elements is -1"));
  CHECK_THROWS_WITH(Axis::fourier({"x"}, 0.0, 1.0, 4), Contains("number of nodes is 4; an odd number"));
  CHECK_THROWS_WITH(Axis::fourier({"x"}, 0.0, 1.0, 1), Contains("number of nodes is 1"));
  CHECK_THROWS_WITH(Axis::fourier({"x"}, 1.0, 1.0, 3), Contains("increasing"));
  CHECK_THROWS_WITH(Axis::fourier({"x"}, 0.0, kNan, 3), Contains("not finite"));
  CHECK_THROWS_WITH(Axis::fourier({"x", "1", AxisRole::parameter, Transform::logarithm}, 1.0, 2.0, 3),
                    Contains("transform \"log\", which a fourier axis cannot have"));
}

TEST_CASE("the table of bases says what axes of each do") {
  for (const Basis basis : {Basis::p1, Basis::chebyshev, Basis::radau, Basis::p2, Basis::legendre,
                            Basis::fourier, Basis::discrete, Basis::imported}) {
    const BasisTraits& traits = basis_traits(basis);
    INFO(traits.name);
    CHECK(traits.basis == basis);
    CHECK((traits.element_nodes != nullptr) == (traits.family == AxisFamily::elements));
    if (traits.element_nodes != nullptr) {
      const Axis axis = Axis::of_elements({"x"}, basis, Eigen::Vector3d(0.0, 1.0, 3.0), 2);
      CHECK(axis.basis() == basis);
      CHECK(axis.elements() == 2);
      CHECK(axis.family() == AxisFamily::elements);
    } else {
      CHECK_THROWS_WITH(Axis::of_elements({"x"}, basis, Eigen::Vector2d(0.0, 1.0), 2), Contains(traits.name));
    }
    if (!traits.discretises_parameters()) continue;
    const int nodes = traits.odd_nodes ? 9 : 8;
    const Axis axis = traits.over_interval({"x"}, 1.0, 2.0, nodes);
    CHECK(axis.basis() == basis);
    CHECK(axis.size() == nodes);
    CHECK(axis.family() == traits.family);
  }
  CHECK(parameter_basis_names() == std::vector<std::string>{"chebyshev", "legendre", "fourier", "p1", "p2"});
}
