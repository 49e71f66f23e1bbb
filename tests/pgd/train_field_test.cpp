#include "samara/pgd/fields/train_field.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "random_tensor.h"
#include "samara/base/errors.h"

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
