#include "samara/pgd/tensors/tensor_train.h"

#include <catch2/catch.hpp>

#include "random_tensor.h"

using namespace samara::pgd;

namespace {

const std::vector<int> kModes = {2, 7, 5, 6};

/// Largest difference of two tensors over their whole (small) grid, relative to the first one's largest
/// entry.
template <class A, class B>
double difference(const A& a, const B& b) {
  double largest = 0.0;
  double scale = 0.0;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 7; ++j)
      for (int k = 0; k < 5; ++k)
        for (int l = 0; l < 6; ++l) {
          const std::vector<int> index = {i, j, k, l};
          largest = std::max(largest, std::abs(a.entry(index) - b.entry(index)));
          scale = std::max(scale, std::abs(a.entry(index)));
        }
  return largest / scale;
}

}  // namespace

TEST_CASE("a sum of products, its train and the sum from the train are one tensor") {
  const SeparatedTensor tensor = random_tensor(kModes, 4, 11);
  const TensorTrain train = to_train(tensor);
  CHECK(difference(tensor, train) < 1e-13);
  CHECK(difference(tensor, rounded(train, 0.0)) < 1e-13);
  CHECK(difference(tensor, to_separated(train)) < 1e-12);
  CHECK(train.ranks() == std::vector<int>{2, 4, 4});
}

TEST_CASE("the norm of a train is that of all entries") {
  const SeparatedTensor tensor = random_tensor(kModes, 3, 5);
  double sum = 0.0;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 7; ++j)
      for (int k = 0; k < 5; ++k)
        for (int l = 0; l < 6; ++l) {
          const std::vector<int> index = {i, j, k, l};
          sum += tensor.entry(index) * tensor.entry(index);
        }
  CHECK(norm(tensor) == Approx(std::sqrt(sum)).epsilon(1e-13));
  CHECK(norm(to_train(tensor)) == Approx(std::sqrt(sum)).epsilon(1e-13));
  CHECK(fast_norm(tensor) == Approx(std::sqrt(sum)).epsilon(1e-12));
}

TEST_CASE("the norm of a difference resolves what the cheap one cannot") {
  const SeparatedTensor tensor = random_tensor(kModes, 3, 5);
  const SeparatedTensor small = random_tensor(kModes, 1, 6);
  SeparatedTensor sum = tensor;
  sum.append(small, 1e-11);
  sum.append(tensor, -1.0);
  // Round-off of the terms is 1e-16 of their size, some 1e3 here.
  CHECK(norm(sum) == Approx(1e-11 * norm(small)).epsilon(1e-2));
}

TEST_CASE("rounding keeps to its tolerance and finds the rank") {
  SeparatedTensor tensor = random_tensor(kModes, 2, 7);
  const SeparatedTensor noise = random_tensor(kModes, 3, 8);
  tensor.append(noise, 1e-6 / norm(noise));
  for (const double tolerance : {1e-3, 1e-5}) {
    const TensorTrain cut = rounded(to_train(tensor), tolerance);
    CHECK(cut.ranks() == std::vector<int>{2, 2, 2});
    SeparatedTensor error = to_separated(cut);
    error.append(tensor, -1.0);
    CHECK(norm(error) <= 1.01e-6);
  }
  CHECK(rounded(to_train(tensor), 1e-12).ranks() == std::vector<int>{2, 5, 5});
}

TEST_CASE("small products are left out of the sum only up to the tolerance") {
  SeparatedTensor tensor = random_tensor(kModes, 3, 9);
  tensor.normalise();
  tensor.weights.setOnes();
  const TensorTrain train = rounded(to_train(tensor), 0.0);
  const SeparatedTensor all = to_separated(train);
  int rank = all.rank();
  for (const double relative : {0.05, 0.1, 0.2, 0.4}) {
    const double tolerance = relative * norm(tensor);
    const SeparatedTensor some = to_separated(train, tolerance);
    CHECK(some.rank() < rank);
    rank = some.rank();
    SeparatedTensor error = some;
    error.append(tensor, -1.0);
    CHECK(norm(error) <= tolerance);
    // By their norms, which bounds the error however the products lie.
    CHECK(all.weights.sum() - some.weights.sum() <= tolerance * (1.0 + 1e-12));
  }
}

TEST_CASE("a tensor without terms is zero in every form") {
  const SeparatedTensor zero = SeparatedTensor::zero(kModes);
  CHECK(norm(zero) == 0.0);
  CHECK(norm(to_train(zero)) == 0.0);
  CHECK(to_separated(to_train(zero)).rank() == 0);
  SeparatedTensor tensor = random_tensor(kModes, 1, 3);
  tensor.append(zero);
  CHECK(tensor.rank() == 1);
}

TEST_CASE("all entries of a tensor become a train of the least ranks, as wrong as it may be") {
  const SeparatedTensor tensor = random_tensor(kModes, 3, 5);
  Eigen::MatrixXd values(2, 7 * 5 * 6);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < values.cols(); ++j)
      values(i, j) = tensor.entry(std::vector<int>{i, j % 7, j / 7 % 5, j / 35});
  const TensorTrain train = to_train(values, {7, 5, 6}, 1e-12 * values.norm());
  CHECK(train.ranks() == std::vector<int>{2, 3, 3});
  CHECK(difference(tensor, train) < 1e-11);
  const double tolerance = 0.1 * values.norm();
  const TensorTrain rough = to_train(values, {7, 5, 6}, tolerance);
  double lost = 0.0;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < values.cols(); ++j)
      lost += std::pow(values(i, j) - rough.entry(std::vector<int>{i, j % 7, j / 7 % 5, j / 35}), 2);
  CHECK(std::sqrt(lost) <= tolerance);
  CHECK_THROWS_WITH(to_train(values, {7, 5}, 0.0), "2 x 210 values for modes of 7 x 5 entries");
}
