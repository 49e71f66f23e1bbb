#include "samara/pgd/cross/field_functions.h"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "field_fixture.h"
#include "samara/base/errors.h"

using namespace samara::pgd;
using Catch::Contains;
using Catch::EndsWith;
using samara::Termination;

namespace {

/// Smooth positive field of two outputs on three Chebyshev axes: 1 + x y + z and 2 + x - 0.5 y z.
SeparatedField smooth(const std::vector<Axis>& axes) {
  std::vector<Eigen::MatrixXd> factors;
  const std::vector<std::vector<int>> powers = {{0, 0, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 1}};
  for (std::size_t k = 0; k < 3; ++k) {
    Eigen::MatrixXd factor(axes[k].size(), 5);
    for (std::size_t r = 0; r < 5; ++r) {
      factor.col(static_cast<Eigen::Index>(r)) = axes[k].nodes().array().pow(powers[r][k]);
    }
    factors.push_back(factor);
  }
  Eigen::MatrixXd weights(2, 5);
  weights << 1.0, 1.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, -0.5;
  return {axes, {{"p", "Pa"}, {"v", "m/s"}}, factors, weights};
}

std::vector<Axis> cube(int nodes) {
  return {Axis::chebyshev({"x"}, 0.0, 1.0, nodes), Axis::chebyshev({"y"}, 0.0, 1.0, nodes),
          Axis::chebyshev({"z", "m"}, 0.0, 1.0, nodes)};
}

/// Largest difference at random points, relative to the largest value of an output.
template <class Function>
double relative_difference(const SeparatedField& field, Function exact) {
  Random random(98);
  double largest = 0.0;
  double size = 0.0;
  for (int i = 0; i < 200; ++i) {
    const std::vector<double> x = random_point(field.axes(), random);
    const Eigen::VectorXd value = exact(x);
    largest = std::max(largest, (field(x) - value).cwiseAbs().maxCoeff());
    size = std::max(size, value.cwiseAbs().maxCoeff());
  }
  return largest / size;
}

/// x - shift on the x axis, one output.
SeparatedField line(const std::vector<Axis>& axes, double shift) {
  std::vector<Eigen::MatrixXd> factors = {axes[0].nodes().array() - shift};
  for (std::size_t k = 1; k < axes.size(); ++k) factors.emplace_back(Eigen::VectorXd::Ones(axes[k].size()));
  return {axes, {{"d", "m"}}, factors, Eigen::MatrixXd::Ones(1, 1)};
}

}  // namespace

TEST_CASE("products and quotients of smooth fields meet their tolerance between the nodes, too") {
  // 12 Chebyshev nodes interpolate these to 1e-8 and better; the tolerance is the larger part.
  const SeparatedField f = smooth(cube(12));
  for (const double tolerance : {1e-3, 1e-6}) {
    const FunctionResult times = product(f, f, {.tolerance = tolerance});
    const FunctionResult ratio = quotient(times.field.value(), f, {.tolerance = tolerance});
    CAPTURE(tolerance, times.message, ratio.message);
    CHECK(times.status == Termination::converged);
    CHECK(times.tolerance_met);
    CHECK(times.error <= tolerance);
    CHECK(times.evaluations > 0);
    CHECK(times.grid_size == 1728.0);
    CHECK(times.field->outputs()[1].name == "v v");
    CHECK(times.field->outputs()[1].unit == "m^2/s^2");
    CHECK(ratio.field->outputs()[0].unit == "Pa");
    // A random check bounds nearly all points, not the worst one: a factor of 20.
    CHECK(relative_difference(*times.field, [&](const std::vector<double>& x) {
            return f(x).cwiseAbs2().eval();
          }) < 20.0 * tolerance);
    CHECK(relative_difference(*ratio.field, [&](const std::vector<double>& x) { return f(x); }) <
          40.0 * tolerance);
  }
}

TEST_CASE("a function of several fields gets all their outputs and gives as many as it likes") {
  const SeparatedField f = smooth(cube(10));
  const SeparatedField g = line(cube(10), -1.0);
  const FunctionResult result = function_of({f, g}, {{"speed", "m/s"}, {"energy"}, {"zero"}},
                                            [](const Eigen::VectorXd& x, Eigen::VectorXd& y) {
                                              y[0] = std::hypot(x[0], x[1]);
                                              y[1] = 1e6 * std::exp(-x[2]);
                                            },
                                            {.tolerance = 1e-5});
  CAPTURE(result.message);
  REQUIRE(result.status == Termination::converged);
  const std::vector<double> x = {0.3, 0.4, 0.8};
  const Eigen::VectorXd value = (*result.field)(x);
  // Outputs of any size are found to their own scale.
  CHECK(value[0] == Approx(std::hypot(f(x)[0], f(x)[1])).epsilon(1e-4));
  CHECK(value[1] == Approx(1e6 * std::exp(-1.3)).epsilon(1e-4));
  CHECK(value[2] == 0.0);
}

TEST_CASE("the derivative of a product is the sum of the products of the derivatives") {
  // Polynomials that the axes hold: degree 1 each, 2 in the product.
  const SeparatedField f = smooth(cube(5));
  const FunctionOptions exact{.tolerance = 1e-10};
  for (const char* axis : {"x", "y", "z"}) {
    const SeparatedField left = derivative(product(f, f, exact).field.value(), axis);
    const SeparatedField half = product(f, derivative(f, axis), exact).field.value();
    CAPTURE(axis);
    CHECK(left.outputs()[0].unit == half.outputs()[0].unit);
    CHECK(relative_difference(left, [&](const std::vector<double>& x) { return (2.0 * half(x)).eval(); }) <
          1e-7);
  }
}

TEST_CASE("one output multiplies or divides all of the other field") {
  const SeparatedField f = smooth(cube(6));
  const SeparatedField g = line(f.axes(), -2.0);
  const FunctionResult times = product(g, f);
  CHECK(times.field->output_count() == 2);
  CHECK(times.field->outputs()[0].name == "d p");
  CHECK(quotient(f, g).field->outputs()[1].name == "v / d");
  CHECK(quotient(f, g).field->outputs()[1].unit == "1/s");
}

TEST_CASE("a denominator that vanishes or changes its sign is named with its place") {
  const SeparatedField f = smooth(cube(9));
  for (const double shift : {0.01, 0.5, 0.995, 0.0, 1.0}) {
    const FunctionResult result = quotient(f, line(f.axes(), shift));
    CAPTURE(shift, result.message);
    CHECK(result.status == Termination::sign_change);
    CHECK_FALSE(result.field.has_value());
    CHECK_FALSE(result.tolerance_met);
    CHECK_THAT(result.message, Contains("denominator d") && Contains("x = ") && Contains("z = "));
    CHECK_THAT(result.message, !Catch::Matches(".*[0-9] 1, .*") && EndsWith(" m"));  // only z has a unit
    REQUIRE(result.point.size() == 3);
  }
  CHECK(quotient(f, line(f.axes(), -0.2)).status == Termination::converged);
}

TEST_CASE("a pocket of the other sign in one corner of five axes is found") {
  // sum of x - 4.9 is positive at the node (1, 1, 1, 1, 1) alone, and some of its neighbours.
  std::vector<Axis> axes;
  for (const char* name : {"a", "b", "c", "d", "e"}) axes.push_back(Axis::p1({name}, 0.0, 1.0, 15));
  std::vector<Eigen::MatrixXd> factors;
  for (int k = 0; k < 5; ++k) {
    Eigen::MatrixXd factor = Eigen::MatrixXd::Ones(15, 6);
    factor.col(k) = axes[0].nodes();
    factors.push_back(factor);
  }
  Eigen::RowVectorXd weights = Eigen::RowVectorXd::Ones(6);
  weights[5] = -4.9;
  const SeparatedField pocket(axes, {{"d"}}, factors, weights);
  const FunctionResult result = quotient(pocket, pocket);
  CHECK(result.status == Termination::sign_change);
  CHECK(result.point == std::vector<double>(5, 1.0));
}

TEST_CASE("the denominator that is named is one without its sign at the place that is named") {
  // Bowls, below zero at ten single nodes each, which a search along lines mostly misses.
  const std::vector<Axis> axes = {Axis::chebyshev({"x"}, 0.0, 1.0, 3), Axis::chebyshev({"y"}, 0.0, 1.0, 40),
                                  Axis::chebyshev({"z"}, 0.0, 1.0, 40)};
  constexpr int kPockets = 20;
  std::vector<Eigen::MatrixXd> factors;
  for (const Axis& axis : axes) {
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(axis.size(), kPockets + 1);
    factor.col(0) = 1.0 + (axis.nodes().array() - axis.nodes()[1]).square();
    factors.push_back(factor);
  }
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(2, kPockets + 1);
  weights.col(0).setOnes();
  for (int p = 0; p < kPockets; ++p) {
    factors[0](0, p + 1) = 1.0;
    factors[1]((7 * p + 3) % 40, p + 1) = 1.0;
    factors[2]((11 * p + 5) % 40, p + 1) = 1.0;
    weights(p % 2, p + 1) = -100.0;
  }
  const SeparatedField below(axes, {{"c"}, {"d"}}, factors, weights);
  int named = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    FunctionOptions options;
    options.seed = seed;
    const FunctionResult result = quotient(below, below, options);
    if (result.status != Termination::sign_change) continue;
    CAPTURE(seed, result.message);
    const bool is_first = result.message.find("denominator c ") != std::string::npos;
    CHECK(below(result.point)[is_first ? 0 : 1] < 0.0);
    ++named;
  }
  CHECK(named > 10);
}

TEST_CASE("a value that is not finite is reported with its output and node, and gives no field") {
  const SeparatedField f = smooth(cube(8));
  const FunctionResult result = function_of(
      {f}, {{"root"}}, [](const Eigen::VectorXd& x, Eigen::VectorXd& y) { y[0] = std::sqrt(x[0] - 2.0); });
  CHECK(result.status == Termination::not_finite);
  CHECK_FALSE(result.field.has_value());
  CHECK_THAT(result.message, Contains("root is") && Contains("nan at x = "));
  REQUIRE(result.point.size() == 3);
  CHECK(f(result.point)[0] < 2.0);
}

TEST_CASE("a tolerance out of reach is reported as missed, with the best field") {
  const SeparatedField f = smooth(cube(12));
  const FunctionResult result = function_of(
      {f}, {{"step"}},
      [](const Eigen::VectorXd& x, Eigen::VectorXd& y) { y[0] = std::tanh(40.0 * (x[0] - x[1])); },
      {.tolerance = 1e-9, .max_rank = 3});
  CHECK(result.status == Termination::missed);
  CHECK_FALSE(result.tolerance_met);
  CHECK(result.error > 1e-9);
  CHECK(result.field.has_value());
  CHECK_THAT(result.message, Contains("> 1e-09") && Contains("train:"));
}

TEST_CASE("functions of fields that do not fit, or with options out of range, are refused") {
  const SeparatedField f = smooth(cube(6));
  const PointFunction copy = [](const Eigen::VectorXd& x, Eigen::VectorXd& y) { y[0] = x[0]; };
  CHECK_THROWS_WITH(function_of({}, {{"u"}}, copy), Contains("number of fields is 0"));
  CHECK_THROWS_WITH(function_of({f}, {}, copy), Contains("number of outputs is 0"));
  CHECK_THROWS_WITH(product(f, smooth(cube(7))), Contains("6 nodes") && Contains("7 nodes"));
  CHECK_THROWS_WITH(function_of({f}, {{"u"}}, copy, {.tolerance = 0.0}), Contains("tolerance is 0"));
  CHECK_THROWS_WITH(function_of({f}, {{"u"}}, copy, {.max_terms = -1}), Contains("max_terms is -1"));
  const SeparatedField three = random_mixed_field(3, 2, 1);
  CHECK_THROWS_WITH(quotient(three, random_mixed_field(2, 2, 2)), Contains("3 and 2 outputs"));
}
