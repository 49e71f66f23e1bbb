#include "samara/pgd/tensors/tensor_algebra.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "random_tensor.h"
#include "samara/base/errors.h"

using namespace samara::pgd;
using Catch::Contains;

namespace {

const std::vector<int> kSizes = {4, 3, 5};

Eigen::VectorXd random_vector(int size, std::uint64_t seed) {
  return random_tensor({size}, 1, seed).factors[0].col(0);
}

}  // namespace

TEST_CASE("sum, multiple and product of sums of products are those of their entries") {
  const SeparatedTensor a = random_tensor(kSizes, 4, 1);
  const SeparatedTensor b = random_tensor(kSizes, 3, 2);
  const SeparatedTensor added = sum(a, b, -0.5);
  const SeparatedTensor multiple = scaled(a, 3.0);
  const SeparatedTensor product = hadamard(a, b);
  CHECK(added.rank() == 7);
  CHECK(product.rank() == 12);
  double error = 0.0;
  for_every_entry(kSizes, [&](const std::vector<int>& i) {
    error = std::max({error, std::abs(added.entry(i) - a.entry(i) + 0.5 * b.entry(i)),
                      std::abs(multiple.entry(i) - 3.0 * a.entry(i)),
                      std::abs(product.entry(i) - a.entry(i) * b.entry(i))});
  });
  // Entries reach 1e2: a few eps of that.
  CHECK(error < 1e-12);
}

TEST_CASE("contraction, restriction and a matrix act on one mode alone") {
  const SeparatedTensor a = random_tensor(kSizes, 4, 3);
  for (int mode = 0; mode < 3; ++mode) {
    const auto k = static_cast<std::size_t>(mode);
    const Eigen::VectorXd weights = random_vector(kSizes[k], 4);
    const Eigen::MatrixXd matrix = random_matrix(6, kSizes[k], 5);
    const SeparatedTensor contraction = contracted(a, mode, weights);
    const SeparatedTensor slice = restricted(a, mode, 1);
    const SeparatedTensor dense = applied(a, mode, matrix);
    const SeparatedTensor sparse = applied(a, mode, SparseMatrix(matrix.sparseView()));
    std::vector<int> other = kSizes;
    other.erase(other.begin() + mode);
    double error = 0.0;
    for_every_entry(other, [&](const std::vector<int>& index) {
      std::vector<int> full = index;
      full.insert(full.begin() + mode, 0);
      Eigen::VectorXd line(kSizes[k]);
      for (int i = 0; i < kSizes[k]; ++i) {
        full[k] = i;
        line[i] = a.entry(full);
      }
      error = std::max({error, std::abs(contraction.entry(index) - weights.dot(line)),
                        std::abs(slice.entry(index) - line[1])});
      for (int i = 0; i < 6; ++i) {
        full[k] = i;
        const double exact = matrix.row(i).dot(line);
        error = std::max({error, std::abs(dense.entry(full) - exact), std::abs(sparse.entry(full) - exact)});
      }
    });
    CAPTURE(mode);
    CHECK(error < 1e-12);
    CHECK(contraction.rank() == 4);
    CHECK(dense.size(mode) == 6);
  }
}

TEST_CASE("the last mode may be contracted to a number") {
  const SeparatedTensor a = random_tensor({5}, 3, 6);
  const Eigen::VectorXd weights = random_vector(5, 7);
  double exact = 0.0;
  for (int i = 0; i < 5; ++i) exact += weights[i] * a.entry(std::vector<int>{i});
  CHECK(contracted(a, 0, weights).entry({}) == Approx(exact));
}

TEST_CASE("the product of sums is commutative, distributive and has the ones as unit") {
  const SeparatedTensor a = random_tensor(kSizes, 2, 8);
  const SeparatedTensor b = random_tensor(kSizes, 3, 9);
  const SeparatedTensor c = random_tensor(kSizes, 2, 10);
  const SeparatedTensor ones = SeparatedTensor::product(
      {Eigen::VectorXd::Ones(4), Eigen::VectorXd::Ones(3), Eigen::VectorXd::Ones(5)});
  const auto difference = [](const SeparatedTensor& x, const SeparatedTensor& y) {
    return fast_norm(sum(x, y, -1.0)) / fast_norm(x);
  };
  // The fast norm resolves half of the digits.
  CHECK(difference(hadamard(a, b), hadamard(b, a)) < 1e-7);
  CHECK(difference(hadamard(a, sum(b, c)), sum(hadamard(a, b), hadamard(a, c))) < 1e-7);
  CHECK(difference(hadamard(a, ones), a) < 1e-7);
  CHECK(hadamard(a, SeparatedTensor::zero(kSizes)).rank() == 0);
}

TEST_CASE("operands that do not fit are refused with both sides named") {
  const SeparatedTensor a = random_tensor(kSizes, 2, 11);
  const SeparatedTensor b = random_tensor({4, 3, 6}, 2, 12);
  CHECK_THROWS_AS(sum(a, b), samara::ArgumentError);
  CHECK_THROWS_WITH(sum(a, b), Contains("4 x 3 x 5") && Contains("4 x 3 x 6"));
  CHECK_THROWS_WITH(hadamard(a, b), Contains("product") && Contains("same grid"));
  CHECK_THROWS_WITH(restricted(a, 3, 0), Contains("mode 3") && Contains("0 to 2"));
  CHECK_THROWS_WITH(restricted(a, 1, 3), Contains("index 3") && Contains("0 to 2"));
  CHECK_THROWS_WITH(contracted(a, 1, Eigen::VectorXd::Ones(4)), Contains("4 nodes") && Contains("has 3"));
  CHECK_THROWS_WITH(applied(a, 2, random_matrix(5, 4, 13)), Contains("4 nodes") && Contains("has 5"));
}
