#include "samara/pgd/fields/train_field.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "random_tensor.h"
#include "samara/base/errors.h"
#include "samara/pgd/fields/field.h"
#include "samara/pgd/fields/field_algebra.h"
#include "samara/pgd/fields/train_field_algebra.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/train_points.h"

using namespace samara::pgd;
using Catch::Contains;

namespace {

const std::vector<Axis>& mixed_axes() {
  static const std::vector<Axis> axes = {Axis::chebyshev({"a"}, 0.5, 2.0, 6),
                                         Axis::p1({"b", "kg"}, -1.0, 1.0, 9),
                                         Axis::radau({"t", "s", AxisRole::time}, 0.0, 3.0, 4, 3)};
  return axes;
}

/// The same values as a sum of products and as a train.
struct Pair {
  SeparatedField sum;
  TrainField train;
};

Pair random_pair(int outputs, int rank, std::uint64_t seed) {
  std::vector<int> sizes = {outputs};
  for (const Axis& axis : mixed_axes()) sizes.push_back(axis.size());
  const SeparatedTensor tensor = random_tensor(sizes, rank, seed);
  const std::vector<OutputLabel> labels(static_cast<std::size_t>(outputs), OutputLabel{"u", "m"});
  return {{mixed_axes(),
           labels,
           {tensor.factors.begin() + 1, tensor.factors.end()},
           tensor.factors[0] * tensor.weights.asDiagonal()},
          {mixed_axes(), labels, to_train(tensor)}};
}

const std::vector<std::vector<double>> kPoints = {
    {0.5, -1.0, 0.0}, {2.0, 1.0, 3.0}, {0.7123, 0.31, 1.77}, {1.9, -0.75, 0.75}, {1.111, 0.9999, 2.5}};

/// Both fields have these outputs over these axes, and these values at points of theirs.
template <AnyField First, AnyField Second>
void check_same(const First& first, const Second& second) {
  REQUIRE(first.axis_count() == second.axis_count());
  for (int k = 0; k < first.axis_count(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    CHECK(first.axes()[at].name() == second.axes()[at].name());
  }
  for (int m = 0; m < first.output_count(); ++m) {
    const auto at = static_cast<std::size_t>(m);
    CHECK(first.outputs()[at].unit == second.outputs()[at].unit);
  }
  auto first_workspace = first.make_workspace();
  auto second_workspace = second.make_workspace();
  Eigen::VectorXd a(first.output_count()), b(first.output_count());
  for (const double part : {0.0, 0.31, 0.77, 1.0}) {
    std::vector<double> x;
    for (const Axis& axis : first.axes()) x.push_back(axis.lower() + part * axis.length());
    first.evaluate(x, a, first_workspace);
    second.evaluate(x, b, second_workspace);
    CHECK((a - b).norm() < 1e-11 * (1.0 + a.norm()));
  }
}

}  // namespace

TEST_CASE("a train of fields has the values and gradients of the sum of products it was made from") {
  for (const int rank : {1, 4, 12}) {
    const Pair pair = random_pair(3, rank, 5);
    SeparatedField::Workspace workspace = pair.sum.make_workspace();
    TrainField::Workspace train_workspace = pair.train.make_workspace();
    Eigen::VectorXd values(3), train_values(3);
    Eigen::MatrixXd gradient(3, 3), train_gradient(3, 3);
    for (const std::vector<double>& x : kPoints) {
      pair.sum.evaluate(x, values, gradient, workspace);
      pair.train.evaluate(x, train_values, train_gradient, train_workspace);
      CHECK((values - train_values).norm() < 1e-12 * (1.0 + values.norm()));
      CHECK((gradient - train_gradient).norm() < 1e-11 * (1.0 + gradient.norm()));
      CHECK((pair.train(x) - train_values).norm() < 1e-14 * (1.0 + values.norm()));
    }
  }
}

TEST_CASE("the entries of a train of fields are those of its cores") {
  // Ranks of a random train of rank 2 are 2 throughout: 2 x 2, then 2 n 2 twice, then 2 n.
  const TrainField field = random_pair(2, 2, 1).train;
  const int n_t = mixed_axes()[2].size();
  CHECK(field.entries() == 2 * 2 + 2 * 6 * 2 + 2 * 9 * 2 + 2 * n_t);
}

TEST_CASE("trains that do not fit their axes, and points outside them, are refused") {
  const Pair pair = random_pair(2, 2, 3);
  TensorTrain train = pair.train.train();
  const std::vector<OutputLabel>& labels = pair.train.outputs();
  CHECK_THROWS_WITH(TrainField({}, labels, train), Contains("number of axes is 0"));
  CHECK_THROWS_WITH(TrainField({mixed_axes()[0]}, labels, train),
                    Contains("number of cores is 4; 2, one for"));
  CHECK_THROWS_WITH(TrainField(mixed_axes(), {{"u"}}, train), Contains("core 0"));
  train.cores[1].data[0] = std::nan("");
  CHECK_THROWS_WITH(TrainField(mixed_axes(), labels, train), Contains("core 1") && Contains("not finite"));
  CHECK_THROWS_AS(pair.train(std::vector<double>{3.0, 0.0, 0.0}), samara::OutsideBoxError);
  CHECK_THROWS_WITH(pair.train(std::vector<double>{1.0, 0.0}), Contains("2 coordinates, expected 3"));
  CHECK_THROWS_WITH(pair.train(std::vector<double>{1.0, std::nan(""), 0.0}), Contains("b is nan"));
}

TEST_CASE("the algebra of trains is that of sums, and fields of either kind keep theirs") {
  const Pair pair = random_pair(2, 3, 7);
  const Pair other = random_pair(2, 2, 8);
  check_same(sum(pair.sum, other.sum, -0.5), sum(pair.train, other.train, -0.5));
  check_same(scaled(pair.sum, 3.0), scaled(pair.train, 3.0));
  for (const Axis& axis : mixed_axes()) {
    const std::string& name = axis.name();
    CAPTURE(name);
    const double x = axis.lower() + 0.37 * axis.length();
    check_same(restricted(pair.sum, name, x), restricted(pair.train, name, x));
    check_same(integral(pair.sum, name), integral(pair.train, name));
    check_same(mean(pair.sum, name), mean(pair.train, name));
    check_same(derivative(pair.sum, name), derivative(pair.train, name));
    const Field of_sum = pair.sum, of_train = pair.train;
    CHECK(restricted(of_sum, name, x).sum() != nullptr);
    CHECK(integral(of_train, name).train() != nullptr);
    check_same(mean(of_sum, name), mean(of_train, name));
    check_same(derivative(of_sum, name), derivative(of_train, name));
    check_same(scaled(of_sum, -2.0), scaled(of_train, -2.0));
  }
}

TEST_CASE("trains refuse what sums refuse, by name") {
  const TrainField field = random_pair(1, 2, 9).train;
  CHECK_THROWS_WITH(restricted(field, "b", 1.5), Contains("b = 1.5 kg") && Contains("[-1, 1]"));
  CHECK_THROWS_AS(restricted(field, "b", 1.5), samara::OutsideBoxError);
  CHECK_THROWS_WITH(integral(field, "c"), Contains("no axis \"c\""));
  CHECK_THROWS_WITH(mean(mean(mean(field, "a"), "b"), "t"), Contains("\"t\" is the only axis"));
  CHECK_THROWS_WITH(sum(field, mean(field, "a")), Contains("3 and 2 axes"));
}

TEST_CASE("many points at once have the values of each by itself, on elements and beyond a block") {
  const TrainField field = random_pair(3, 5, 11).train;
  Random random(4);
  Eigen::MatrixXd points(3, 150);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Axis& axis = field.axes()[static_cast<std::size_t>(k)];
      points(k, j) = axis.lower() + axis.length() * random.uniform();
    }
  }
  const Eigen::MatrixXd many = many_values_at(field.train(), field.axes(), points);
  const Eigen::MatrixXd each = values_at(field.train(), field.axes(), points);
  CHECK((many - each).cwiseAbs().maxCoeff() < 1e-13 * each.cwiseAbs().maxCoeff());
}
