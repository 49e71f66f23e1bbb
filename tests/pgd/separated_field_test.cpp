#include "samara/pgd/fields/separated_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <thread>

#include <catch2/catch.hpp>

#include "random_tensor.h"
#include "samara/base/errors.h"
#include "samara/pgd/axes/quadrature.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

std::vector<Axis> three_kinds() {
  return {Axis::radau({"t", "s", AxisRole::time}, 0.0, 2.0, 3, 4), Axis::chebyshev({"C_D"}, 0.5, 2.0, 6),
          Axis::p1({"v(0)", "m/s", AxisRole::initial}, -0.3, 0.6, 7)};
}

/// A function of one coordinate and its derivative.
struct Curve {
  std::function<double(double)> value;
  std::function<double(double)> derivative;
};

Eigen::VectorXd sampled(const Axis& axis, const Curve& curve) {
  return axis.nodes().unaryExpr([&](double x) { return curve.value(x); });
}

SeparatedField random_field(const std::vector<Axis>& axes, int outputs, int rank, std::uint64_t seed) {
  std::vector<int> sizes = {outputs};
  for (const Axis& axis : axes) sizes.push_back(axis.size());
  SeparatedTensor tensor = random_tensor(sizes, rank, seed);
  const Eigen::MatrixXd weights = tensor.factors[0] * tensor.weights.asDiagonal();
  tensor.factors.erase(tensor.factors.begin());
  std::vector<OutputLabel> labels;
  for (int m = 0; m < outputs; ++m) labels.push_back({std::string(1, static_cast<char>('u' + m)), "m/s"});
  return {axes, labels, tensor.factors, weights};
}

std::vector<double> random_point(const std::vector<Axis>& axes, Random& random) {
  std::vector<double> x;
  for (const Axis& axis : axes) x.push_back(axis.lower() + axis.length() * random.uniform());
  return x;
}

struct Answer {
  Eigen::VectorXd values;
  Eigen::MatrixXd gradient;
};

Answer evaluate(const SeparatedField& field, const std::vector<double>& x) {
  SeparatedField::Workspace workspace = field.make_workspace();
  Answer answer{Eigen::VectorXd(field.output_count()),
                Eigen::MatrixXd(field.output_count(), field.axis_count())};
  field.evaluate(x, answer.values, answer.gradient, workspace);
  return answer;
}

/// Integral of a factor's square over its axis by a rule on every element that does not use the axis'
/// matrices.
double squared_integral(const SeparatedField& field, int axis, int term) {
  const Axis& a = field.axes()[static_cast<std::size_t>(axis)];
  const QuadratureRule rule = gauss_legendre(a.degree() + 1);
  InterpolationStencil stencil = a.make_stencil();
  Eigen::VectorXd values(field.rank());
  double sum = 0.0;
  for (int e = 0; e < a.elements(); ++e) {
    const double half = 0.5 * (a.borders()[e + 1] - a.borders()[e]);
    for (Eigen::Index q = 0; q < rule.nodes.size(); ++q) {
      field.factor_values(axis, a.borders()[e] + half * (1.0 + rule.nodes[q]), stencil, values);
      sum += half * rule.weights[q] * values[term] * values[term];
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("at nodes the field is the table it was made from") {
  const std::vector<Axis> axes = three_kinds();
  std::vector<int> sizes = {2};
  for (const Axis& axis : axes) sizes.push_back(axis.size());
  const SeparatedTensor table = random_tensor(sizes, 5, 1);
  const Eigen::MatrixXd weights = table.factors[0] * table.weights.asDiagonal();
  const SeparatedField field(axes, {{"u", "m/s"}, {"v", "m/s"}},
                             {table.factors.begin() + 1, table.factors.end()}, weights);
  CHECK(field.rank() == 5);
  CHECK(field.axis_count() == 3);
  CHECK(field.output_count() == 2);
  SeparatedField::Workspace workspace = field.make_workspace();
  Eigen::VectorXd values(2);
  double largest = 0.0;
  for_every_entry({sizes.begin() + 1, sizes.end()}, [&](const std::vector<int>& index) {
    std::vector<double> x;
    for (std::size_t k = 0; k < axes.size(); ++k) x.push_back(axes[k].nodes()[index[k]]);
    field.evaluate(x, values, workspace);
    for (int m = 0; m < 2; ++m) {
      const std::vector<int> entry = {m, index[0], index[1], index[2]};
      largest = std::max(largest, std::abs(values[m] - table.entry(entry)));
    }
  });
  // Entries are sums of five products of three normal numbers; scaling to length one and back costs a few
  // eps.
  CHECK(largest < 1e-13);
}

TEST_CASE("products of polynomials are represented exactly, with their gradients") {
  // Degrees up to what the axes hold: 4 (radau), 5 (Chebyshev) and 1 (finite elements).
  const std::vector<Axis> axes = three_kinds();
  const std::array<std::array<Curve, 3>, 2> terms = {
      {{Curve{[](double t) { return 1.0 + t - 0.3 * t * t * t * t; },
              [](double t) { return 1.0 - 1.2 * t * t * t; }},
        Curve{[](double c) { return c * c * c * c * c - 2.0; }, [](double c) { return 5.0 * c * c * c * c; }},
        Curve{[](double v) { return 0.2 + v; }, [](double) { return 1.0; }}},
       {Curve{[](double t) { return t * t; }, [](double t) { return 2.0 * t; }},
        Curve{[](double) { return 1.0; }, [](double) { return 0.0; }},
        Curve{[](double v) { return 1.0 - 3.0 * v; }, [](double) { return -3.0; }}}}};
  std::vector<Eigen::MatrixXd> factors;
  for (std::size_t k = 0; k < 3; ++k) {
    Eigen::MatrixXd factor(axes[k].size(), 2);
    for (std::size_t r = 0; r < 2; ++r)
      factor.col(static_cast<Eigen::Index>(r)) = sampled(axes[k], terms[r][k]);
    factors.push_back(factor);
  }
  const Eigen::MatrixXd weights = (Eigen::MatrixXd(2, 2) << 1.0, -2.0, 0.5, 3.0).finished();
  const SeparatedField field(axes, {{"u"}, {"v"}}, factors, weights);
  Random random(2);
  double value_error = 0.0;
  double gradient_error = 0.0;
  for (int i = 0; i < 500; ++i) {
    const std::vector<double> x = random_point(axes, random);
    const Answer answer = evaluate(field, x);
    for (int m = 0; m < 2; ++m) {
      double exact = 0.0;
      Eigen::Vector3d slope = Eigen::Vector3d::Zero();
      for (std::size_t r = 0; r < 2; ++r) {
        const double weight = weights(m, static_cast<Eigen::Index>(r));
        const auto f = [&](std::size_t k) { return terms[r][k].value(x[k]); };
        exact += weight * f(0) * f(1) * f(2);
        slope[0] += weight * terms[r][0].derivative(x[0]) * f(1) * f(2);
        slope[1] += weight * f(0) * terms[r][1].derivative(x[1]) * f(2);
        slope[2] += weight * f(0) * f(1) * terms[r][2].derivative(x[2]);
      }
      value_error = std::max(value_error, std::abs(answer.values[m] - exact));
      gradient_error = std::max(gradient_error, (answer.gradient.row(m).transpose() - slope).norm());
    }
  }
  // Values reach 2e2, slopes 4e2; the differentiation matrices amplify eps by degree^2 / element length, 1e2.
  CHECK(value_error < 1e-12);
  CHECK(gradient_error < 1e-10);
}

TEST_CASE("the gradient is the limit of central differences inside the elements") {
  const std::vector<Axis> axes = three_kinds();
  const SeparatedField field = random_field(axes, 2, 6, 3);
  // Third derivatives of degree-5 polynomials through random values reach 1e5 per unit^3: h^2 / 6 of it is
  // 2e-8 at h = 1e-6, round-off 1e-14 / h = 1e-8.
  const double h = 1e-6;
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const std::vector<double> x = random_point(axes, random);
    const Answer answer = evaluate(field, x);
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const auto near_border = [&](double border) { return std::abs(border - x[k]) < 2.0 * h; };
      if (std::any_of(axes[k].borders().begin(), axes[k].borders().end(), near_border)) continue;
      std::vector<double> forward = x;
      std::vector<double> backward = x;
      forward[k] += h;
      backward[k] -= h;
      const Eigen::VectorXd difference = (field(forward) - field(backward)) / (forward[k] - backward[k]);
      CAPTURE(x, k);
      CHECK((answer.gradient.col(static_cast<Eigen::Index>(k)) - difference).norm() <
            1e-7 * (10.0 + difference.norm()));
    }
  }
}

TEST_CASE("on the border of two elements the gradient is the one from the left") {
  const std::vector<Axis> axes = {Axis::p1({"x"}, 0.0, 2.0, 3)};
  const Eigen::MatrixXd hat = Eigen::Vector3d(0.0, 1.0, -1.0);
  const SeparatedField field(axes, {{"u"}}, {hat}, Eigen::MatrixXd::Ones(1, 1));
  CHECK(evaluate(field, {1.0}).gradient(0, 0) == Approx(1.0));
  CHECK(evaluate(field, {std::nextafter(1.0, 2.0)}).gradient(0, 0) == Approx(-2.0));
  CHECK(evaluate(field, {0.0}).gradient(0, 0) == Approx(1.0));
  CHECK(evaluate(field, {2.0}).gradient(0, 0) == Approx(-2.0));
}

TEST_CASE("both forms of evaluation and the convenience form agree") {
  const std::vector<Axis> axes = three_kinds();
  const SeparatedField field = random_field(axes, 3, 7, 5);
  SeparatedField::Workspace workspace = field.make_workspace();
  Eigen::VectorXd values(3);
  Random random(6);
  for (int i = 0; i < 50; ++i) {
    const std::vector<double> x = random_point(axes, random);
    field.evaluate(x, values, workspace);
    CHECK((values - evaluate(field, x).values).norm() <= 1e-14 * (1.0 + values.norm()));
    CHECK(values == field(x));
  }
}

TEST_CASE("the field is linear in its weights") {
  const std::vector<Axis> axes = three_kinds();
  const SeparatedField u = random_field(axes, 2, 4, 7);
  const Eigen::MatrixXd other = random_field(axes, 2, 4, 8).weights();
  const SeparatedField v(axes, u.outputs(), u.factors(), other);
  const SeparatedField sum(axes, u.outputs(), u.factors(), 2.0 * u.weights() - 0.5 * other);
  Random random(9);
  for (int i = 0; i < 50; ++i) {
    const std::vector<double> x = random_point(axes, random);
    const Answer a = evaluate(u, x);
    const Answer b = evaluate(v, x);
    const Answer c = evaluate(sum, x);
    CHECK((c.values - 2.0 * a.values + 0.5 * b.values).norm() < 1e-12);
    CHECK((c.gradient - 2.0 * a.gradient + 0.5 * b.gradient).norm() < 1e-11 * (1.0 + c.gradient.norm()));
  }
}

TEST_CASE("outputs share the factors: a group equals its outputs taken alone") {
  const std::vector<Axis> axes = three_kinds();
  const SeparatedField group = random_field(axes, 3, 5, 10);
  Random random(11);
  for (int i = 0; i < 20; ++i) {
    const std::vector<double> x = random_point(axes, random);
    const Answer together = evaluate(group, x);
    for (int m = 0; m < 3; ++m) {
      const SeparatedField alone(axes, {group.outputs()[static_cast<std::size_t>(m)]}, group.factors(),
                                 group.weights().row(m));
      CHECK(alone(x)[0] == Approx(together.values[m]).margin(1e-13));
      CHECK((evaluate(alone, x).gradient - together.gradient.row(m)).norm() <
            1e-12 * (1.0 + together.gradient.norm()));
    }
  }
}

TEST_CASE("factors have length one and weights are the root mean squares of the terms over the box") {
  const std::vector<Axis> axes = three_kinds();
  std::vector<int> sizes;
  for (const Axis& axis : axes) sizes.push_back(axis.size());
  SeparatedTensor tensor = random_tensor(sizes, 4, 12);
  tensor.factors[1].col(2) *= 1e9;
  tensor.factors[2].col(3).setZero();
  const SeparatedField field(axes, {{"u"}, {"v"}}, tensor.factors, Eigen::MatrixXd::Constant(2, 4, -0.5));
  double box = 1.0;
  for (const Axis& axis : axes) box *= axis.length();
  for (int r = 0; r < 3; ++r) {
    double mean_square = 1.0;
    double given = 1.0;
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const Eigen::VectorXd column = tensor.factors[i].col(r);
      CHECK(squared_integral(field, k, r) == Approx(axes[i].length()).epsilon(1e-12));
      mean_square *= squared_integral(field, k, r);
      given *= column.dot(axes[i].mass() * column) / axes[i].length();
    }
    CHECK(std::abs(field.weights()(0, r)) == Approx(0.5 * std::sqrt(given)).epsilon(1e-12));
    // The term itself: weight^2 times the integral of the product's square over the box.
    CHECK(field.weights()(0, r) < 0.0);
    CHECK(mean_square / box == Approx(1.0).epsilon(1e-12));
  }
  // A term without size stays one, without becoming NaN.
  CHECK(field.factors()[2].col(3).norm() == 0.0);
  CHECK(field(std::vector<double>{1.0, 1.0, 0.1}).allFinite());
}

TEST_CASE("a field without terms is zero") {
  const std::vector<Axis> axes = three_kinds();
  std::vector<Eigen::MatrixXd> none;
  for (const Axis& axis : axes) none.emplace_back(axis.size(), 0);
  const SeparatedField field(axes, {{"u"}, {"v"}}, none, Eigen::MatrixXd(2, 0));
  const Answer answer = evaluate(field, {1.0, 1.0, 0.0});
  CHECK(answer.values.norm() == 0.0);
  CHECK(answer.gradient.norm() == 0.0);
}

TEST_CASE("the borders belong to the box and the next number does not") {
  const std::vector<Axis> axes = three_kinds();
  const SeparatedField field = random_field(axes, 1, 3, 13);
  const std::vector<double> inside = {1.0, 1.0, 0.1};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < axes.size(); ++k) {
    std::vector<double> x = inside;
    x[k] = axes[k].lower();
    CHECK(std::isfinite(field(x)[0]));
    x[k] = std::nextafter(axes[k].lower(), -kInfinity);
    CHECK_THROWS_AS(field(x), samara::OutsideBoxError);
    x[k] = axes[k].upper();
    CHECK(std::isfinite(field(x)[0]));
    x[k] = std::nextafter(axes[k].upper(), kInfinity);
    CHECK_THROWS_AS(field(x), samara::OutsideBoxError);
  }
}

TEST_CASE("a point outside the box is refused with name, value, unit and bounds") {
  const SeparatedField field = random_field(three_kinds(), 1, 3, 14);
  CHECK_THROWS_WITH(field(std::vector<double>{1.0, 1.0, 0.75}),
                    Contains("v(0) = 0.75 m/s") && Contains("[-0.3, 0.6]"));
  CHECK_THROWS_WITH(field(std::vector<double>{1.0, 2.5, 0.1}), Contains("C_D = 2.5") && Contains("[0.5, 2]"));
  SeparatedField::Workspace workspace = field.make_workspace();
  Eigen::VectorXd values(1);
  Eigen::MatrixXd gradient(1, 3);
  CHECK_THROWS_AS(field.evaluate(std::vector<double>{-0.1, 1.0, 0.1}, values, workspace),
                  samara::OutsideBoxError);
  CHECK_THROWS_AS(field.evaluate(std::vector<double>{-0.1, 1.0, 0.1}, values, gradient, workspace),
                  samara::OutsideBoxError);
}

TEST_CASE("a point that is not finite or has another size is refused") {
  const SeparatedField field = random_field(three_kinds(), 1, 3, 15);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    CHECK_THROWS_AS(field(std::vector<double>{1.0, bad, 0.1}), samara::ArgumentError);
    CHECK_THROWS_WITH(field(std::vector<double>{1.0, bad, 0.1}), Contains("C_D") && Contains("finite"));
  }
  CHECK_THROWS_AS(field(std::vector<double>{1.0, 1.0}), samara::ArgumentError);
  CHECK_THROWS_WITH(field(std::vector<double>{1.0, 1.0, 0.1, 0.0}),
                    Contains("4 coordinates") && Contains("expected 3"));
}

TEST_CASE("parts of a field that do not fit together are refused") {
  const std::vector<Axis> axes = three_kinds();
  const SeparatedField good = random_field(axes, 2, 3, 16);
  const auto make = [&](const std::vector<Axis>& a, const std::vector<OutputLabel>& outputs,
                        const std::vector<Eigen::MatrixXd>& factors, const Eigen::MatrixXd& weights) {
    return SeparatedField(a, outputs, factors, weights);
  };
  CHECK_NOTHROW(make(axes, good.outputs(), good.factors(), good.weights()));
  CHECK_THROWS_AS(make({}, good.outputs(), {}, good.weights()), samara::ArgumentError);
  CHECK_THROWS_AS(make(axes, {}, good.factors(), Eigen::MatrixXd(0, 3)), samara::ArgumentError);
  CHECK_THROWS_WITH(make(axes, {{"u"}}, good.factors(), good.weights()),
                    Contains("rows of weights is 2; 1, one per output"));
  CHECK_THROWS_WITH(make({axes[0], axes[1]}, good.outputs(), good.factors(), good.weights()),
                    Contains("factor matrices is 3; 2, one per axis"));
  std::vector<Eigen::MatrixXd> factors = good.factors();
  factors[1].conservativeResize(5, Eigen::NoChange);
  CHECK_THROWS_WITH(make(axes, good.outputs(), factors, good.weights()),
                    Contains("\"C_D\"") && Contains("5 x 3") && Contains("6 x 3"));
  factors = good.factors();
  factors[2](0, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(make(axes, good.outputs(), factors, good.weights()),
                    Contains("\"v(0)\"") && Contains("not finite"));
  Eigen::MatrixXd weights = good.weights();
  weights(1, 1) = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(make(axes, good.outputs(), good.factors(), weights), Contains("not finite"));
  CHECK_THROWS_AS(make(axes, good.outputs(), good.factors(), good.weights().leftCols(2)),
                  samara::ArgumentError);
}

TEST_CASE("factors whose squares overflow give the same field, and terms that do are refused") {
  const std::vector<Axis> axes = three_kinds();
  const SeparatedField field = random_field(axes, 2, 3, 17);
  std::vector<Eigen::MatrixXd> factors = field.factors();
  factors[0] *= 1e200;
  const SeparatedField scaled(axes, field.outputs(), factors, 1e-200 * field.weights());
  Random random(18);
  const std::vector<double> middle = random_point(axes, random);
  CHECK((scaled(middle) - field(middle)).norm() <= 1e-12 * field(middle).norm());
  factors[1] *= 1e200;
  CHECK_THROWS_WITH(SeparatedField(axes, field.outputs(), factors, field.weights()), Contains("a term of"));
}

TEST_CASE("a copy does not depend on what it was copied from") {
  const std::vector<Axis> axes = three_kinds();
  const std::vector<double> x = {0.7, 1.1, 0.2};
  SeparatedField original = random_field(axes, 2, 4, 17);
  const SeparatedField copy = original;
  const Eigen::VectorXd before = original(x);
  original = random_field({axes[0], axes[1], axes[2]}, 2, 9, 18);
  CHECK(copy(x) == before);
  CHECK(original(x) != before);
  CHECK(copy.rank() == 4);
}

TEST_CASE("threads with their own workspaces get the same values as one thread") {
  const std::vector<Axis> axes = three_kinds();
  const SeparatedField field = random_field(axes, 3, 20, 19);
  Random random(20);
  std::vector<std::vector<double>> points;
  for (int i = 0; i < 2000; ++i) points.push_back(random_point(axes, random));
  const auto all = [&](std::vector<Answer>& answers) {
    SeparatedField::Workspace workspace = field.make_workspace();
    for (const std::vector<double>& x : points) {
      answers.push_back({Eigen::VectorXd(3), Eigen::MatrixXd(3, 3)});
      field.evaluate(x, answers.back().values, answers.back().gradient, workspace);
    }
  };
  std::array<std::vector<Answer>, 4> results;
  std::vector<std::thread> threads;
  for (std::vector<Answer>& result : results) threads.emplace_back([&] { all(result); });
  for (std::thread& thread : threads) thread.join();
  std::vector<Answer> alone;
  all(alone);
  for (const std::vector<Answer>& result : results) {
    REQUIRE(result.size() == alone.size());
    int different = 0;
    for (std::size_t i = 0; i < alone.size(); ++i) {
      if (result[i].values != alone[i].values || result[i].gradient != alone[i].gradient) ++different;
    }
    CHECK(different == 0);
  }
}
