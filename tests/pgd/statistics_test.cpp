#include "samara/pgd/fields/statistics.h"

#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "random_tensor.h"
#include "samara/base/errors.h"
#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/fields/field_algebra.h"

using namespace samara::pgd;
using Catch::Contains;

namespace {

constexpr double kPi = std::numbers::pi;

std::string numbered(char letter, int number) {
  std::string name(1, letter);
  name += std::to_string(number);
  return name;
}

Eigen::MatrixXd columns(const std::vector<Eigen::VectorXd>& list) {
  Eigen::MatrixXd matrix(list.front().size(), static_cast<Eigen::Index>(list.size()));
  for (std::size_t r = 0; r < list.size(); ++r) matrix.col(static_cast<Eigen::Index>(r)) = list[r];
  return matrix;
}

/// Ishigami and Homma (1990): sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 on [-pi, pi]^3, three terms.
SeparatedField ishigami(int nodes) {
  std::vector<Axis> axes;
  for (const char* name : {"x1", "x2", "x3"}) axes.push_back(Axis::chebyshev({name}, -kPi, kPi, nodes));
  const Eigen::ArrayXd x = axes[0].nodes().array();
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(nodes);
  const Eigen::VectorXd sine = x.sin();
  return {axes,
          {{"f"}},
          {columns({sine, one, sine}), columns({one, x.sin().square(), one}), columns({one, one, x.pow(4)})},
          Eigen::RowVector3d(1.0, 7.0, 0.1)};
}

/// Closed forms of its variance parts.
struct Ishigami {
  double b = 0.1;
  double v1 = 0.5 * std::pow(1.0 + b * std::pow(kPi, 4) / 5.0, 2);
  double v2 = 49.0 / 8.0;
  double v13 = b * b * std::pow(kPi, 8) * (1.0 / 18.0 - 1.0 / 50.0);
  double variance() const { return v1 + v2 + v13; }
};

/// Random field of cubic factors on [0, 1]^d, with one time axis in front if asked for.
SeparatedField random_field(int axes_count, int outputs, int rank, std::uint64_t seed) {
  std::vector<Axis> axes;
  std::vector<int> sizes = {outputs};
  for (int k = 0; k < axes_count; ++k) {
    axes.push_back(k == 1 ? Axis::p1({numbered('x', k)}, -1.0, 2.0, 5)
                          : Axis::chebyshev({numbered('x', k)}, 0.0, 1.0, 4));
    sizes.push_back(axes.back().size());
  }
  std::vector<OutputLabel> labels;
  for (int m = 0; m < outputs; ++m) labels.push_back({numbered('u', m)});
  return field_from_nodal_values(axes, labels, random_tensor(sizes, rank, seed));
}

double difference(const Statistics& a, const Statistics& b) {
  double largest =
      std::max((a.mean - b.mean).cwiseAbs().maxCoeff(), (a.variance - b.variance).cwiseAbs().maxCoeff());
  for (std::size_t k = 0; k < a.inputs.size(); ++k) {
    largest = std::max(largest, (a.first_order[k] - b.first_order[k]).cwiseAbs().maxCoeff());
    largest = std::max(largest, (a.total[k] - b.total[k]).cwiseAbs().maxCoeff());
  }
  return largest;
}

TrainField as_train(const SeparatedField& field) {
  return {field.axes(), field.outputs(), to_train(nodal_values(field))};
}

}  // namespace

TEST_CASE("the Ishigami function has its closed-form mean, variance and Sobol' indices") {
  const Statistics s =
      statistics(ishigami(30), {.subsets = {{"x1", "x3"}, {"x3", "x2"}, {"x1", "x2", "x3"}}});
  const Ishigami exact;
  const double d = exact.variance();
  // Chebyshev interpolation with 30 nodes of sin^2 on [-pi, pi] is exact to 1e-11.
  CHECK(s.mean(0, 0) == Approx(3.5).epsilon(1e-10));
  CHECK(s.variance(0, 0) == Approx(d).epsilon(1e-10));
  const std::vector<double> first = {exact.v1 / d, exact.v2 / d, 0.0};
  const std::vector<double> total = {(exact.v1 + exact.v13) / d, exact.v2 / d, exact.v13 / d};
  for (std::size_t k = 0; k < 3; ++k) {
    CAPTURE(k);
    CHECK(std::abs(s.first_order[k](0, 0) - first[k]) < 1e-10);
    CHECK(std::abs(s.total[k](0, 0) - total[k]) < 1e-10);
  }
  CHECK(s.subsets[0].interaction(0, 0) == Approx(exact.v13 / d).epsilon(1e-9));
  CHECK(s.subsets[0].closed(0, 0) == Approx((exact.v1 + exact.v13) / d).epsilon(1e-9));
  CHECK(s.subsets[1].closed(0, 0) == Approx(exact.v2 / d).epsilon(1e-9));
  CHECK(s.subsets[1].total(0, 0) == Approx((exact.v2 + exact.v13) / d).epsilon(1e-9));
  CHECK(std::abs(s.subsets[1].interaction(0, 0)) < 1e-10);
  CHECK(s.subsets[2].closed(0, 0) == Approx(1.0).epsilon(1e-12));
  CHECK(s.subsets[2].total(0, 0) == Approx(1.0).epsilon(1e-12));
  CHECK(s.inputs == std::vector<std::string>{"x1", "x2", "x3"});
  CHECK(s.free_nodes.size() == 0);
}

TEST_CASE("Sobol's g-function has its closed-form indices in four to six dimensions") {
  // g = prod (|4 x - 2| + a_k) / (1 + a_k): exact on P1 axes with a node at the kink. V_k = 1/3 / (1 +
  // a_k)^2.
  for (int d = 4; d <= 6; ++d) {
    std::vector<Axis> axes;
    std::vector<Eigen::MatrixXd> factors;
    std::vector<double> v;
    double all = 1.0;
    for (int k = 0; k < d; ++k) {
      const double a = 0.5 * k * k;
      axes.push_back(Axis::p1({numbered('x', k)}, 0.0, 1.0, 3));
      factors.push_back((((4.0 * axes.back().nodes().array() - 2.0).abs() + a) / (1.0 + a)).matrix());
      v.push_back(1.0 / 3.0 / std::pow(1.0 + a, 2));
      all *= 1.0 + v.back();
    }
    const SeparatedField field(axes, {{"g"}}, factors, Eigen::MatrixXd::Ones(1, 1));
    const Statistics s = statistics(field, {.subsets = {{"x0", "x2"}}});
    CAPTURE(d);
    CHECK(s.mean(0, 0) == Approx(1.0).epsilon(1e-13));
    CHECK(s.variance(0, 0) == Approx(all - 1.0).epsilon(1e-12));
    for (std::size_t k = 0; k < v.size(); ++k) {
      CHECK(s.first_order[k](0, 0) == Approx(v[k] / (all - 1.0)).epsilon(1e-12));
      CHECK(s.total[k](0, 0) == Approx(v[k] * all / (1.0 + v[k]) / (all - 1.0)).epsilon(1e-12));
    }
    CHECK(s.subsets[0].interaction(0, 0) == Approx(v[0] * v[2] / (all - 1.0)).epsilon(1e-12));
    CHECK(s.subsets[0].closed(0, 0) ==
          Approx(((1.0 + v[0]) * (1.0 + v[2]) - 1.0) / (all - 1.0)).epsilon(1e-12));
  }
}

TEST_CASE("mean and variance agree with Monte Carlo within its own standard error") {
  const SeparatedField field = random_field(4, 2, 5, 1);
  const Statistics s = statistics(field);
  constexpr int kSamples = 20000;
  Random random(7);
  Eigen::MatrixXd values(2, kSamples);
  for (int i = 0; i < kSamples; ++i) {
    std::vector<double> x;
    for (const Axis& axis : field.axes()) x.push_back(axis.lower() + axis.length() * random.uniform());
    values.col(i) = field(x);
  }
  for (int m = 0; m < 2; ++m) {
    const double mean = values.row(m).mean();
    const Eigen::ArrayXd square = (values.row(m).array() - mean).square();
    const double variance = square.mean();
    const double variance_error = std::sqrt((square - variance).square().mean() / kSamples);
    // Five standard errors: wrong once in two million.
    CHECK(std::abs(s.mean(m, 0) - mean) < 5.0 * std::sqrt(variance / kSamples));
    CHECK(std::abs(s.variance(m, 0) - variance) < 5.0 * variance_error);
  }
}

TEST_CASE("on a list every value counts the same, whatever lies between them") {
  // f = v + x with v in {1, 2, 7}: mean 10/3 + 1/2, variances 62/9 and 1/12.
  const std::vector<Axis> axes = {Axis::discrete({"v"}, Eigen::Vector3d(1.0, 2.0, 7.0)),
                                  Axis::chebyshev({"x"}, 0.0, 1.0, 3)};
  const SeparatedField f(axes, {{"f"}},
                         {columns({axes[0].nodes(), Eigen::VectorXd::Ones(3)}),
                          columns({Eigen::VectorXd::Ones(3), axes[1].nodes()})},
                         Eigen::RowVector2d(1.0, 1.0));
  const double of_list = 62.0 / 9.0;
  const double whole = of_list + 1.0 / 12.0;
  const Statistics s = statistics(f);
  CHECK(s.mean(0, 0) == Approx(10.0 / 3.0 + 0.5).epsilon(1e-13));
  CHECK(s.variance(0, 0) == Approx(whole).epsilon(1e-13));
  CHECK(s.first_order[0](0, 0) == Approx(of_list / whole).epsilon(1e-13));
  CHECK(mean(f, "v")(std::vector<double>{0.25})[0] == Approx(10.0 / 3.0 + 0.25).epsilon(1e-13));
  CHECK(root_mean_square(f)[0] == Approx(std::sqrt(whole + std::pow(10.0 / 3.0 + 0.5, 2))).epsilon(1e-13));
}

TEST_CASE("indices lie between zero and one, and first orders and totals enclose the whole") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SeparatedField field = random_field(4, 2, 6, 10 + seed);
    const Statistics s = statistics(field, {.subsets = {{"x0", "x2"}, {"x1", "x3"}}});
    for (int m = 0; m < 2; ++m) {
      double first = 0.0;
      double total = 0.0;
      for (std::size_t k = 0; k < 4; ++k) {
        CHECK(s.first_order[k](m, 0) >= 0.0);
        CHECK(s.total[k](m, 0) >= s.first_order[k](m, 0));
        CHECK(s.total[k](m, 0) <= 1.0 + 1e-12);
        first += s.first_order[k](m, 0);
        total += s.total[k](m, 0);
      }
      CHECK(first <= 1.0 + 1e-12);
      CHECK(total >= 1.0 - 1e-12);
      // Complements: total(A) = 1 - closed(others).
      CHECK(s.subsets[0].total(m, 0) == Approx(1.0 - s.subsets[1].closed(m, 0)).margin(1e-12));
      const double inner = s.first_order[0](m, 0) + s.first_order[2](m, 0) + s.subsets[0].interaction(m, 0);
      CHECK(s.subsets[0].closed(m, 0) == Approx(inner).margin(1e-12));
      // E[f^2] = variance + mean^2.
      CHECK(std::pow(root_mean_square(field)[m], 2) ==
            Approx(s.variance(m, 0) + std::pow(s.mean(m, 0), 2)).epsilon(1e-12));
    }
  }
}

TEST_CASE("a train and the sum it stands for have the same statistics, with and without a free axis") {
  const SeparatedField field = random_field(4, 3, 5, 20);
  const TrainField train = as_train(field);
  for (const char* free : {"", "x0", "x2", "x3"}) {
    CAPTURE(free);
    CHECK(difference(statistics(field, {.free_axis = free}), statistics(train, {.free_axis = free})) < 1e-10);
    CHECK(difference(statistics(train, {.free_axis = free}), statistics(Field(train), {.free_axis = free})) ==
          0.0);
    CHECK(difference(statistics(field, {.free_axis = free}), statistics(Field(field), {.free_axis = free})) ==
          0.0);
  }
}

TEST_CASE("with a free axis the statistics at its nodes are those of the field restricted to them") {
  const SeparatedField field = random_field(3, 2, 4, 30);
  const Statistics s = statistics(field, {.free_axis = "x1"});
  REQUIRE(s.mean.cols() == field.axes()[1].size());
  CHECK(s.free_nodes == field.axes()[1].nodes());
  CHECK(s.inputs == std::vector<std::string>{"x0", "x2"});
  for (Eigen::Index i = 0; i < s.mean.cols(); ++i) {
    const Statistics one = statistics(restricted(field, "x1", s.free_nodes[i]));
    for (int m = 0; m < 2; ++m) {
      CHECK(s.mean(m, i) == Approx(one.mean(m, 0)).margin(1e-12));
      CHECK(s.variance(m, i) == Approx(one.variance(m, 0)));
      CHECK(s.total[1](m, i) == Approx(one.total[1](m, 0)).margin(1e-12));
    }
  }
}

TEST_CASE("a variance of one beside a mean of a million keeps its digits") {
  // sqrt(12) (x - 1/2) has variance 1 on [0, 1]; half of it on each of two axes.
  const std::vector<Axis> axes = {Axis::chebyshev({"x"}, 0.0, 1.0, 5), Axis::p1({"y"}, 0.0, 1.0, 7)};
  const auto line = [](const Axis& axis) -> Eigen::VectorXd {
    return std::sqrt(6.0) * (axis.nodes().array() - 0.5);
  };
  const auto one = [](const Axis& axis) -> Eigen::VectorXd { return Eigen::VectorXd::Ones(axis.size()); };
  const SeparatedField apart(axes, {{"f"}},
                             {columns({one(axes[0]), line(axes[0]), one(axes[0])}),
                              columns({one(axes[1]), one(axes[1]), line(axes[1])})},
                             Eigen::RowVector3d(1e6, 1.0, 1.0));
  // The mean inside a factor, and hidden in terms that cancel.
  const SeparatedField inside(
      axes, {{"f"}},
      {columns({line(axes[0]) + 1e6 * one(axes[0]), one(axes[0])}), columns({one(axes[1]), line(axes[1])})},
      Eigen::RowVector2d(1.0, 1.0));
  const SeparatedField cancelling = sum(sum(apart, inside), inside, -1.0);
  for (const SeparatedField& field : {apart, inside, cancelling}) {
    for (const Statistics& s : {statistics(field), statistics(as_train(field))}) {
      // Nodal values of 1e6 hold 1e-10 of the line: eps 1e6, and as much from every sum over nodes.
      CHECK(s.mean(0, 0) == Approx(1e6).epsilon(1e-14));
      CHECK(s.variance(0, 0) == Approx(1.0).epsilon(1e-8));
      CHECK(s.first_order[0](0, 0) == Approx(0.5).epsilon(1e-8));
      CHECK(s.total[1](0, 0) == Approx(0.5).epsilon(1e-8));
    }
  }
}

TEST_CASE(
    "a function that does not vary has indices of zero and a flag, also at single nodes of the free axis") {
  const std::vector<Axis> axes = {Axis::chebyshev({"t"}, 0.0, 1.0, 4), Axis::chebyshev({"x"}, 0.0, 1.0, 3)};
  // 5 + t x: constant in x at t = 0 only.
  const SeparatedField field(axes, {{"f"}},
                             {columns({Eigen::VectorXd::Ones(4), axes[0].nodes()}),
                              columns({Eigen::VectorXd::Ones(3), axes[1].nodes()})},
                             Eigen::RowVector2d(5.0, 1.0));
  const Statistics s = statistics(field, {.free_axis = "t"});
  CHECK(s.constant(0, 0) == 1);
  CHECK(s.variance(0, 0) == 0.0);
  CHECK(s.first_order[0](0, 0) == 0.0);
  CHECK(s.total[0](0, 0) == 0.0);
  CHECK(s.mean(0, 0) == Approx(5.0));
  for (Eigen::Index i = 1; i < 4; ++i) {
    CHECK(s.constant(0, i) == 0);
    CHECK(s.total[0](0, i) == Approx(1.0));
    CHECK(s.variance(0, i) == Approx(s.free_nodes[i] * s.free_nodes[i] / 12.0));
  }
  const SeparatedField nothing(axes, {{"f"}}, {Eigen::MatrixXd(4, 0), Eigen::MatrixXd(3, 0)},
                               Eigen::MatrixXd(1, 0));
  CHECK(statistics(nothing).constant(0, 0) == 1);
  CHECK(statistics(as_train(nothing)).constant(0, 0) == 1);
}

TEST_CASE("requests for statistics that make no sense are refused") {
  const SeparatedField field = random_field(3, 1, 2, 40);
  CHECK_THROWS_WITH(statistics(field, {.free_axis = "X1"}), Contains("\"X1\"") && Contains("did you mean"));
  CHECK_THROWS_WITH(statistics(field, {.subsets = {{}}}), Contains("empty"));
  CHECK_THROWS_WITH(statistics(field, {.subsets = {{"x0", "x0"}}}), Contains("\"x0\" twice"));
  CHECK_THROWS_WITH(statistics(field, {.free_axis = "x0", .subsets = {{"x0"}}}), Contains("free axis"));
  CHECK_THROWS_WITH(statistics(random_field(1, 1, 2, 41), {.free_axis = "x0"}), Contains("only axis"));
  CHECK_THROWS_WITH(statistics(as_train(field), {.free_axis = "X1"}), Contains("did you mean"));
}

TEST_CASE(
    "a rule for the uniform distribution gives what no rule gives, and rules without meaning are refused",
    "[pgd]") {
  const SeparatedField field = random_field(3, 2, 4, 5);
  StatisticsOptions options;
  for (const Axis& axis : field.axes()) {
    // Two points in each of so many equal parts that borders of elements are among their ends.
    const QuadratureRule panel = gauss_legendre(6);
    QuadratureRule rule{Eigen::VectorXd(24), Eigen::VectorXd(24)};
    for (int k = 0; k < 4; ++k) {
      const double from = axis.lower() + 0.25 * k * axis.length();
      rule.nodes.segment(6 * k, 6) = from + 0.125 * axis.length() * (1.0 + panel.nodes.array());
      rule.weights.segment(6 * k, 6) = panel.weights / 8.0;
    }
    options.distributions[axis.name()] = rule;
  }
  CHECK(difference(statistics(field), statistics(field, options)) < 1e-11);
  CHECK(difference(statistics(as_train(field)), statistics(as_train(field), options)) < 1e-11);

  const auto refusal = [&](const QuadratureRule& rule) {
    return error_text<samara::Error>([&] { statistics(field, {.distributions = {{"x0", rule}}}); });
  };
  CHECK_THAT(refusal({Eigen::Vector2d(0.1, 0.2), Eigen::Vector2d(0.5, 0.6)}), Contains("sum to 1.1"));
  CHECK_THAT(refusal({Eigen::Vector2d(0.1, 1.2), Eigen::Vector2d(0.5, 0.5)}), Contains("node 1.2"));
  CHECK_THAT(refusal({Eigen::Vector2d(0.1, 0.2), Eigen::Vector2d(-0.5, 1.5)}), Contains("-0.5"));
  CHECK_THAT(refusal({Eigen::Vector2d(0.1, 0.2), Eigen::Vector3d(0.5, 0.3, 0.2)}),
             Contains("one weight a node"));
  CHECK_THAT(error_text<samara::Error>([&] {
               statistics(field, {.free_axis = "x0", .distributions = {{"x0", {}}}});
             }),
             Contains("free axis"));
}

TEST_CASE("moments of a discrete distribution are sums over its values", "[pgd]") {
  const SeparatedField field = random_field(2, 1, 3, 8);
  const QuadratureRule rule{Eigen::Vector3d(0.1, 0.45, 0.9), Eigen::Vector3d(0.2, 0.5, 0.3)};
  const Statistics s = statistics(field, {.free_axis = "x1", .distributions = {{"x0", rule}}});
  auto workspace = field.make_workspace();
  Eigen::VectorXd value(1);
  for (Eigen::Index i = 0; i < s.free_nodes.size(); ++i) {
    double mean = 0.0, square = 0.0;
    for (Eigen::Index k = 0; k < 3; ++k) {
      field.evaluate(std::vector<double>{rule.nodes[k], s.free_nodes[i]}, value, workspace);
      mean += rule.weights[k] * value[0];
      square += rule.weights[k] * value[0] * value[0];
    }
    CHECK(s.mean(0, i) == Approx(mean).margin(1e-12));
    CHECK(s.variance(0, i) == Approx(square - mean * mean).margin(1e-11));
  }
}
