#include "samara/pgd/fields/field_algebra.h"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "field_fixture.h"
#include "samara/base/errors.h"
#include "samara/pgd/axes/quadrature.h"

using namespace samara::pgd;
using Catch::Contains;

namespace {

/// Integral of f_m g_m over the box by Gauss quadrature in every element: the dense route.
double dense_inner(const SeparatedField& f, const SeparatedField& g, int m) {
  std::vector<std::vector<std::pair<double, double>>> rules;  // per axis: point, weight
  std::vector<int> sizes;
  for (const Axis& axis : f.axes()) {
    const QuadratureRule rule = gauss_legendre(axis.degree() + 1);
    rules.emplace_back();
    for (int e = 0; e < axis.elements(); ++e) {
      const double half = 0.5 * (axis.borders()[e + 1] - axis.borders()[e]);
      for (Eigen::Index q = 0; q < rule.nodes.size(); ++q) {
        rules.back().emplace_back(axis.borders()[e] + half * (1.0 + rule.nodes[q]), half * rule.weights[q]);
      }
    }
    sizes.push_back(static_cast<int>(rules.back().size()));
  }
  double integral = 0.0;
  for_every_entry(sizes, [&](const std::vector<int>& index) {
    std::vector<double> x;
    double weight = 1.0;
    for (std::size_t k = 0; k < rules.size(); ++k) {
      x.push_back(rules[k][static_cast<std::size_t>(index[k])].first);
      weight *= rules[k][static_cast<std::size_t>(index[k])].second;
    }
    integral += weight * f(x)[m] * g(x)[m];
  });
  return integral;
}

/// Largest difference between a field and a function at random points.
template <class Function>
double difference(const SeparatedField& field, Function exact) {
  Random random(99);
  double largest = 0.0;
  for (int i = 0; i < 100; ++i) {
    const std::vector<double> x = random_point(field.axes(), random);
    largest = std::max(largest, (field(x) - exact(x)).cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace

TEST_CASE("sum and multiple of fields are those of their values") {
  const SeparatedField f = random_mixed_field(2, 4, 1);
  const SeparatedField g = random_mixed_field(2, 3, 2);
  using Point = std::vector<double>;
  // Values reach 1e3 between nodes: a few eps of that.
  CHECK(difference(sum(f, g, -0.5), [&](const Point& x) { return (f(x) - 0.5 * g(x)).eval(); }) < 1e-11);
  CHECK(difference(scaled(f, 3.0), [&](const Point& x) { return (3.0 * f(x)).eval(); }) < 1e-11);
  CHECK(sum(f, g).outputs()[1].unit == "m/s");
}

TEST_CASE("inner products and norms are the integrals over the box") {
  const SeparatedField f = random_mixed_field(2, 4, 3);
  const SeparatedField g = random_mixed_field(2, 3, 4);
  const Eigen::VectorXd products = l2_inner(f, g);
  const Eigen::VectorXd size_f = l2_norm(f);
  const Eigen::VectorXd size_g = l2_norm(g);
  for (int m = 0; m < 2; ++m) {
    CHECK(products[m] == Approx(dense_inner(f, g, m)).epsilon(1e-11));
    CHECK(size_f[m] == Approx(std::sqrt(dense_inner(f, f, m))).epsilon(1e-11));
    // Cauchy and Schwarz, and the triangle.
    CHECK(std::abs(products[m]) <= size_f[m] * size_g[m]);
    CHECK(l2_norm(sum(f, g))[m] <= size_f[m] + size_g[m]);
    CHECK(root_mean_square(f)[m] == Approx(size_f[m] / std::sqrt(2.0 * 1.5 * 0.9)));
  }
  // Where terms cancel the norm still has digits.
  const SeparatedField small = sum(f, sum(scaled(f, -1.0), scaled(g, 1e-9)));
  CHECK(l2_norm(small)[0] == Approx(1e-9 * size_g[0]).epsilon(1e-5));
}

TEST_CASE("restriction is evaluation with one coordinate fixed") {
  const SeparatedField f = random_mixed_field(2, 4, 5);
  const SeparatedField fixed = restricted(f, "C_D", 1.234);
  REQUIRE(fixed.axis_count() == 2);
  CHECK(fixed.axes()[1].name() == "x");
  CHECK(difference(fixed, [&](const std::vector<double>& x) {
          return f(std::vector<double>{x[0], 1.234, x[1]});
        }) < 1e-11);
  const SeparatedField line = restricted(fixed, "t", 2.0);
  CHECK(line(std::vector<double>{0.1})[1] == Approx(f(std::vector<double>{2.0, 1.234, 0.1})[1]));
}

TEST_CASE("the integral over an axis is the length times the mean, in either order of axes") {
  const SeparatedField f = random_mixed_field(2, 4, 6);
  const SeparatedField over_t = integral(f, "t");
  CHECK(over_t.outputs()[0].unit == "m");
  CHECK(mean(f, "t").outputs()[0].unit == "m/s");
  const Eigen::VectorXd a = integral(integral(f, "t"), "x")(std::vector<double>{1.0});
  const Eigen::VectorXd b = integral(integral(f, "x"), "t")(std::vector<double>{1.0});
  const Eigen::VectorXd c = mean(mean(f, "x"), "t")(std::vector<double>{1.0});
  CHECK((a - b).norm() < 1e-12 * a.norm());
  CHECK((a - 2.0 * 0.9 * c).norm() < 1e-12 * a.norm());
  // The inner product with one is the integral over all axes.
  const SeparatedField one(f.axes(), f.outputs(),
                           {Eigen::VectorXd::Ones(7), Eigen::VectorXd::Ones(5), Eigen::VectorXd::Ones(4)},
                           Eigen::MatrixXd::Ones(2, 1));
  const SeparatedField rest = integral(integral(f, "x"), "t");
  const SeparatedField rest_one(rest.axes(), rest.outputs(), {Eigen::VectorXd::Ones(5)},
                                Eigen::MatrixXd::Ones(2, 1));
  CHECK((l2_inner(f, one) - l2_inner(rest, rest_one)).norm() < 1e-12 * l2_inner(f, one).norm());
}

TEST_CASE("the derivative is the exact gradient at nodes, and its integral is the difference of the ends") {
  const SeparatedField f = random_mixed_field(2, 4, 7);
  for (const char* name : {"t", "C_D"}) {
    const int k = axis_index(f, name);
    const Axis& axis = f.axes()[static_cast<std::size_t>(k)];
    const SeparatedField slope = derivative(f, name);
    const SeparatedField total = integral(slope, name);
    const SeparatedField ends =
        sum(restricted(f, name, axis.upper()), restricted(f, name, axis.lower()), -1.0);
    CAPTURE(name);
    // Degrees 2 and 3: the quadrature weights of both kinds integrate the derivative exactly.
    CHECK(difference(ends, [&](const std::vector<double>& x) { return total(x); }) < 1e-10);
    CHECK(total.outputs()[0].unit == "m/s");
    SeparatedField::Workspace workspace = f.make_workspace();
    Eigen::VectorXd values(2);
    Eigen::MatrixXd gradient(2, 3);
    std::vector<double> x = {0.3, 0.7, 0.2};
    for (const double node : axis.nodes()) {
      x[static_cast<std::size_t>(k)] = node;
      f.evaluate(x, values, gradient, workspace);
      CHECK((slope(x) - gradient.col(k)).norm() < 1e-9);
    }
  }
  CHECK(derivative(f, "t").outputs()[0].unit == "m/s^2");
  CHECK(derivative(f, "C_D").outputs()[0].unit == "m/s");
  CHECK(derivative(f, "x").outputs()[0].unit == "1/s");
}

TEST_CASE("operations on fields are linear") {
  const SeparatedField f = random_mixed_field(2, 4, 8);
  const SeparatedField g = random_mixed_field(2, 3, 9);
  const SeparatedField both = sum(f, g, 2.5);
  const auto check = [&](auto operation) {
    const SeparatedField separate = sum(operation(f), operation(g), 2.5);
    CHECK(difference(operation(both), [&](const std::vector<double>& x) { return separate(x); }) < 1e-9);
  };
  check([](const SeparatedField& u) { return restricted(u, "t", 0.4); });
  check([](const SeparatedField& u) { return integral(u, "x"); });
  check([](const SeparatedField& u) { return mean(u, "C_D"); });
  check([](const SeparatedField& u) { return derivative(u, "t"); });
}

TEST_CASE("a compressed field is within the tolerance of every output's own norm") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SeparatedField f = random_mixed_field(3, 5, seed);
    // Outputs of very different sizes, terms twice, and one output that is zero.
    Eigen::MatrixXd weights = f.weights();
    weights.row(1) *= 1e-6;
    weights.row(2).setZero();
    f = SeparatedField(f.axes(), f.outputs(), f.factors(), weights);
    const SeparatedField redundant = sum(f, scaled(f, 0.3));
    for (const double tolerance : {1e-1, 1e-4, 1e-9}) {
      const FieldCompression result = compress(redundant, tolerance);
      const Eigen::VectorXd error = l2_norm(sum(result.field, redundant, -1.0));
      const Eigen::VectorXd size = l2_norm(redundant);
      CAPTURE(seed, tolerance);
      CHECK(result.tolerance_met);
      CHECK(result.field.rank() <= 5);
      for (int m = 0; m < 2; ++m) {
        CHECK(error[m] <= tolerance * size[m] * (1.0 + 1e-6));
        CHECK(error[m] / size[m] == Approx(result.error[m]).margin(1e-12));
      }
      CHECK(error[2] == 0.0);
    }
  }
  const FieldCompression impossible = compress(random_mixed_field(1, 3, 50), 1e-30);
  CHECK_FALSE(impossible.tolerance_met);
}

TEST_CASE("fields that do not fit, unknown axes and points outside are refused by name") {
  const SeparatedField f = random_mixed_field(2, 3, 60);
  const std::vector<Axis>& axes = f.axes();
  const auto on = [&](const Axis& axis) {
    std::vector<Eigen::MatrixXd> factors = f.factors();
    factors[1] = Eigen::MatrixXd::Ones(axis.size(), 3);
    return SeparatedField({axes[0], axis, axes[2]}, f.outputs(), factors, f.weights());
  };
  CHECK_NOTHROW(sum(f, on(axes[1])));
  CHECK_THROWS_WITH(sum(f, on(Axis::chebyshev({"C_D"}, 0.5, 2.0, 6))),
                    Contains("5 nodes") && Contains("6 nodes"));
  CHECK_THROWS_WITH(sum(f, on(Axis::chebyshev({"C_T"}, 0.5, 2.0, 5))), Contains("\"C_T\""));
  CHECK_THROWS_WITH(l2_inner(f, on(Axis::p1({"C_D"}, 0.5, 2.0, 5))), Contains("of p1 on"));
  CHECK_THROWS_WITH(sum(f, on(Axis::chebyshev({"C_D"}, 0.5, 2.1, 5))), Contains("[0.5, 2.1]"));
  // Nodes alone do not say what a field is between them, or which of them counts for how much.
  const auto field_on = [](const Axis& axis) {
    return SeparatedField({axis}, {{"u"}}, {Eigen::MatrixXd::Ones(2, 1)}, Eigen::MatrixXd::Ones(1, 1));
  };
  const auto elements = [&](Transform transform) {
    return field_on(
        Axis::chebyshev({"C_D", "1", AxisRole::parameter, transform}, Eigen::Vector2d(1.0, 4.0), 1));
  };
  CHECK_THROWS_WITH(sum(elements(Transform::none), elements(Transform::logarithm)),
                    Contains("on [1, 4], log)"));
  const auto imported = [&](double weight) {
    SparseMatrix mass(2, 2);
    mass.insert(0, 0) = 1.0;
    mass.insert(1, 1) = weight;
    return field_on(Axis::imported({"C_D"}, mass));
  };
  CHECK_NOTHROW(l2_inner(imported(1.0), imported(1.0)));
  CHECK_THROWS_WITH(l2_inner(imported(1.0), imported(3.0)), Contains("expected the same nodes"));
  CHECK_THROWS_WITH(sum(f, restricted(f, "t", 0.0)), Contains("3 and 2 axes"));
  CHECK_THROWS_WITH(sum(f, random_mixed_field(1, 3, 61)), Contains("2 and 1 outputs"));
  CHECK_THROWS_WITH(sum(f, derivative(f, "t")), Contains("\"u\" in m/s") && Contains("m/s^2"));
  CHECK_THROWS_WITH(integral(f, "C_d"), Contains("no axis \"C_d\"") && Contains("did you mean \"C_D\""));
  CHECK_THROWS_WITH(derivative(f, "pressure"), Contains("known: t, C_D, x"));
  CHECK_THROWS_AS(restricted(f, "t", 2.5), samara::OutsideBoxError);
  CHECK_THROWS_WITH(restricted(f, "t", 2.5), Contains("t = 2.5 s") && Contains("[0, 2]"));
  CHECK_THROWS_WITH(restricted(f, "t", std::numeric_limits<double>::quiet_NaN()), Contains("finite"));
  CHECK_THROWS_WITH(mean(mean(mean(f, "t"), "x"), "C_D"), Contains("\"C_D\" is the only axis"));
  CHECK_THROWS_WITH(compress(f, 0.0), Contains("tolerance is 0"));
  CHECK_THROWS_AS(field_from_nodal_values(axes, f.outputs(), SeparatedTensor{}), samara::ArgumentError);
}
