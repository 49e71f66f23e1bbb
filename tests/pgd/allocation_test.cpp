#include <cstdlib>
#include <vector>

#include <catch2/catch.hpp>

#include "../allocation_counter.h"
#include "random_tensor.h"
#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/linear/fixed_point.h"

using namespace samara::pgd;

namespace {

SeparatedField typical_field(int outputs, int rank) {
  const std::vector<Axis> axes = {Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 8, 6),
                                  Axis::chebyshev({"C_D"}, 0.5, 2.0, 20), Axis::p1({"m", "kg"}, 1.0, 2.0, 50),
                                  Axis::chebyshev({"v(0)", "m/s"}, -1.0, 1.0, 28)};
  std::vector<int> sizes = {outputs};
  for (const Axis& axis : axes) sizes.push_back(axis.size());
  const SeparatedTensor tensor = random_tensor(sizes, rank, 1);
  const Eigen::MatrixXd weights = tensor.factors[0] * tensor.weights.asDiagonal();
  return {axes,
          std::vector<OutputLabel>(static_cast<std::size_t>(outputs), OutputLabel{"u"}),
          {tensor.factors.begin() + 1, tensor.factors.end()},
          weights};
}

/// Identity plus three products: dense on the states and in time, diagonal on the parameters, as evolution
/// problems have them.
SeparatedOperator evolution_operator(const std::vector<int>& sizes) {
  SeparatedOperator op;
  std::vector<ModeOperator> identity;
  for (const int n : sizes) identity.push_back(ModeOperator::identity(n));
  op.terms.push_back(identity);
  Random random(2);
  const auto small = [&random](Eigen::Index) { return 0.05 * random.normal(); };
  for (int i = 0; i < 3; ++i) {
    std::vector<ModeOperator> term;
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      const Eigen::VectorXd values = Eigen::VectorXd::NullaryExpr(sizes[k] * (k < 2 ? sizes[k] : 1), small);
      if (k < 2) {
        term.push_back(
            ModeOperator::dense(Eigen::Map<const Eigen::MatrixXd>(values.data(), sizes[k], sizes[k])));
      } else {
        term.push_back(ModeOperator::diagonal(values));
      }
    }
    op.terms.push_back(std::move(term));
  }
  return op;
}

Product random_start(const std::vector<int>& sizes, std::uint64_t seed) {
  const SeparatedTensor tensor = random_tensor(sizes, 1, seed);
  Product product;
  for (const Eigen::MatrixXd& factor : tensor.factors) product.factors.emplace_back(factor.col(0));
  return product;
}

}  // namespace

TEST_CASE("the count sees allocations in this program and inside the library") {
  CHECK(allocation_counter::during([] {}) == 0);
  CHECK(allocation_counter::during([] { std::vector<double>(10).front() = 1.0; }) == 2);
  const SeparatedField field = typical_field(1, 5);
  CHECK(allocation_counter::during([&] { field.make_workspace(); }) > 0);
  CHECK(allocation_counter::during([&] { field(std::vector<double>{0.5, 1.0, 1.5, 0.0}); }) > 0);
}

TEST_CASE("evaluating a separated field does not allocate") {
  for (const int outputs : {1, 6}) {
    for (const int rank : {1, 20, 300}) {
      const SeparatedField field = typical_field(outputs, rank);
      SeparatedField::Workspace workspace = field.make_workspace();
      Eigen::VectorXd values(outputs);
      Eigen::MatrixXd gradient(outputs, field.axis_count());
      Eigen::VectorXd terms(rank);
      Eigen::VectorXd slopes(rank);
      InterpolationStencil stencil = field.axes()[0].make_stencil();
      // Inside elements, at nodes and at borders.
      const std::vector<std::vector<double>> points = {
          {0.31, 1.1, 1.234, 0.4}, {0.0, 0.5, 1.0, -1.0}, {0.125, 2.0, 2.0, 1.0}};
      CAPTURE(outputs, rank);
      for (const std::vector<double>& x : points) {
        CHECK(allocation_counter::during([&] { field.evaluate(x, values, workspace); }) == 0);
        CHECK(allocation_counter::during([&] { field.evaluate(x, values, gradient, workspace); }) == 0);
        CHECK(allocation_counter::during([&] { field.factor_values(0, x[0], stencil, terms); }) == 0);
        CHECK(allocation_counter::during([&] { field.factor_values(0, x[0], stencil, terms, slopes); }) == 0);
      }
    }
  }
}

TEST_CASE("interpolation on an axis of any kind does not allocate") {
  const Axis::Label logarithmic{"x", "1", AxisRole::parameter, Transform::logarithm};
  const std::vector<Axis> axes = {
      Axis::p2({"x"}, 1.0, 2.0, 9), Axis::legendre({"x"}, Eigen::Vector3d(1.0, 1.2, 2.0), 30),
      Axis::chebyshev(logarithmic, 1.0, 2.0, 30), Axis::fourier({"x"}, 1.0, 2.0, 101),
      Axis::discrete({"x"}, Eigen::Vector2d(1.0, 2.0))};
  for (const Axis& axis : axes) {
    InterpolationStencil stencil = axis.make_stencil();
    CAPTURE(to_string(axis.basis()));
    for (const double x : {1.0, 1.234, 2.0}) {
      CHECK(allocation_counter::during([&] { axis.interpolate(x, stencil, false); }) == 0);
      CHECK(allocation_counter::during([&] { axis.interpolate(x, stencil, true); }) == 0);
      CHECK(allocation_counter::during([&] { (void)axis.contains(x); }) == 0);
    }
  }
}

TEST_CASE("the fixed point does not allocate once it has run on a right-hand side of the same size") {
  const std::vector<int> sizes = {2, 48, 10, 28};
  LinearProblem problem;
  problem.op = evolution_operator(sizes);
  problem.rhs = random_tensor(sizes, 200, 3);
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    // Least squares square the operator's four terms, and bring as many to the right-hand side.
    const ProjectedForm form = project(problem, projection);
    std::vector<ModeSystem> systems = make_mode_systems(form.a, SparseSolverKind::automatic);
    FixedPoint fixed_point(form, systems);
    fixed_point.deflate(random_tensor(sizes, 30, 6));
    const FixedPoint::Options options{20, 1e-2, Acceleration::aitken};
    Product warm_up = random_start(sizes, 4);
    fixed_point.run(options, warm_up);
    REQUIRE_FALSE(warm_up.singular);
    Product product = random_start(sizes, 5);
    CHECK(allocation_counter::during([&] { fixed_point.run(options, product); }) == 0);
    CHECK(product.iterations > 1);
    CHECK(product.amplitude > 0.0);
  }
}
