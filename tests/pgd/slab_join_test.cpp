#include "samara/pgd/evolution/slab_join.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/tensor_train.h"

using namespace samara::pgd;

namespace {

/// u = exp(-p t) cos(q) and v = t p, at the nodes of a slab: a sum of many terms as a train.
TrainField slab(double begin, double end, int nodes) {
  const std::vector<Axis> axes = {
      Axis::radau({"t", "s", AxisRole::time}, Eigen::Vector2d(begin, end), 8),
      Axis::chebyshev({"p"}, 0.5, 2.0, nodes),
      Axis::chebyshev({"q"}, 0.0, 1.0, 9),
  };
  SeparatedTensor tensor;
  const int terms = axes[0].size() * axes[1].size() + 1;
  tensor.weights = Eigen::VectorXd::Ones(terms);
  tensor.factors = {Eigen::MatrixXd::Zero(2, terms), Eigen::MatrixXd::Zero(axes[0].size(), terms),
                    Eigen::MatrixXd::Zero(axes[1].size(), terms),
                    Eigen::MatrixXd::Zero(axes[2].size(), terms)};
  int term = 0;
  for (int i = 0; i < axes[0].size(); ++i) {
    for (int j = 0; j < axes[1].size(); ++j, ++term) {
      tensor.factors[0](0, term) = 1.0;
      tensor.factors[1](i, term) = std::exp(-axes[1].nodes()[j] * axes[0].nodes()[i]);
      tensor.factors[2](j, term) = 1.0;
      tensor.factors[3].col(term) = axes[2].nodes().array().cos();
    }
  }
  tensor.factors[0](1, term) = 1.0;
  tensor.factors[1].col(term) = axes[0].nodes();
  tensor.factors[2].col(term) = axes[1].nodes();
  tensor.factors[3].col(term).setOnes();
  return TrainField(axes, {{"u", "1"}, {"v", "1"}}, rounded(to_train(tensor), 1e-12));
}

std::vector<TrainField> slabs() {
  return {slab(0.0, 0.3, 11), slab(0.3, 0.7, 14), slab(0.7, 1.0, 11)};
}

double largest_error(const std::vector<TrainField>& fields) {
  Random random(5);
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double x[] = {random.uniform(), 0.5 + 1.5 * random.uniform(), random.uniform()};
    for (const TrainField& field : fields) {
      if (!field.axes()[0].contains(x[0])) continue;
      const Eigen::VectorXd value = field(x);
      worst = std::max({worst, std::abs(value[0] - std::exp(-x[1] * x[0]) * std::cos(x[2])),
                        0.5 * std::abs(value[1] - x[0] * x[1])});
      break;
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("slabs made compact are one field of fewer numbers, within the tolerance") {
  const std::vector<TrainField> all = slabs();
  long before = 0;
  for (const TrainField& field : all) before += field.entries();
  REQUIRE(largest_error(all) < 1e-9);
  long last = before;
  for (const double tolerance : {1e-8, 1e-5, 1e-2}) {
    const std::vector<TrainField> compact =
        compacted(all, Eigen::Vector2d(1.0, 2.0), {.tolerance = tolerance});
    REQUIRE(compact.size() == 1);
    CHECK(largest_error(compact) < tolerance);
    CHECK(compact[0].entries() < last);
    last = compact[0].entries();
    CHECK(compact[0].axes()[0].lower() == 0.0);
    CHECK(compact[0].axes()[0].upper() == 1.0);
    // The motion is smooth: one element of degree 8 follows it but for the last digits.
    CHECK(compact[0].axes()[0].elements() <= (tolerance < 1e-6 ? 2 : 1));
    CHECK(compact[0].axes()[1].size() < 11);
  }
}

TEST_CASE("fields that do not follow each other stay apart") {
  const std::vector<TrainField> gap = {slab(0.0, 0.3, 7), slab(0.5, 0.7, 7)};
  CHECK(compacted(gap, Eigen::Vector2d(1.0, 1.0), {.tolerance = 1e-4}).size() == 2);
}

TEST_CASE("scales and tolerances without meaning are refused") {
  CHECK_THROWS_AS(compacted(slabs(), Eigen::Vector2d(1.0, 0.0), {}), samara::ArgumentError);
  CHECK_THROWS_AS(compacted(slabs(), Eigen::VectorXd::Ones(1), {}), samara::ArgumentError);
  CHECK_THROWS_AS(compacted(slabs(), Eigen::Vector2d(1.0, 1.0), {.tolerance = 0.0}), samara::ArgumentError);
}
