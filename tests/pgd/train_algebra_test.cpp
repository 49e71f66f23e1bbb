#include "samara/pgd/tensors/train_algebra.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "random_tensor.h"
#include "round_off_matrix.h"
#include "samara/base/errors.h"
#include "samara/pgd/tensors/tensor_algebra.h"
#include "samara/pgd/tensors/thin_svd.h"

using namespace samara::pgd;
using Catch::Contains;

namespace {

const std::vector<int> kTrainSizes = {4, 3, 5, 2};

/// Largest difference of entries between a train and a sum.
double difference(const TensorTrain& train, const SeparatedTensor& tensor) {
  REQUIRE(train.modes() == tensor.modes());
  double largest = 0.0;
  for_every_entry(tensor.sizes(), [&](const std::vector<int>& index) {
    largest = std::max(largest, std::abs(train.entry(index) - tensor.entry(index)));
  });
  return largest;
}

}  // namespace

TEST_CASE(
    "singular values and vectors of a matrix with columns of round-off are finite and make the matrix") {
  const Eigen::MatrixXd matrix = round_off_matrix();
  const ThinSvd svd = thin_svd(matrix);
  const Eigen::MatrixXd made = svd.u * svd.singular.asDiagonal() * svd.v.transpose();
  CHECK((made - matrix).norm() < 1e-13 * matrix.norm());
  CHECK((svd.u.transpose() * svd.u - Eigen::MatrixXd::Identity(61, 61)).norm() < 1e-12);
  CHECK((svd.v.transpose() * svd.v - Eigen::MatrixXd::Identity(61, 61)).norm() < 1e-12);
  CHECK((svd.singular.head(60) - svd.singular.tail(60)).minCoeff() >= 0.0);
}

TEST_CASE("sum, multiple, product and inner product of trains are those of the sums they stand for") {
  const SeparatedTensor a = random_tensor(kTrainSizes, 4, 1);
  const SeparatedTensor b = random_tensor(kTrainSizes, 3, 2);
  const TensorTrain ta = to_train(a);
  const TensorTrain tb = to_train(b);
  // Entries reach 1e2 and products 1e4: a few eps of that.
  CHECK(difference(sum(ta, tb, -0.5), sum(a, b, -0.5)) < 1e-12);
  CHECK(difference(scaled(ta, 3.0), scaled(a, 3.0)) < 1e-12);
  CHECK(difference(hadamard(ta, tb), hadamard(a, b)) < 1e-10);
  CHECK(inner(ta, tb) == Approx(inner(a, b)).epsilon(1e-12));
  CHECK(distance(ta, tb) == Approx(norm(sum(a, b, -1.0))).epsilon(1e-12));
  CHECK(distance(ta, ta) < 1e-13 * norm(ta));
  CHECK(sum(ta, tb).ranks() == std::vector<int>{7, 7, 7});
}

TEST_CASE("the rounded product differs from the product by its tolerance at most") {
  const SeparatedTensor a = random_tensor({6, 7, 6, 5}, 5, 3);
  const SeparatedTensor b = random_tensor({6, 7, 6, 5}, 4, 4);
  const TensorTrain exact = hadamard(to_train(a), to_train(b));
  const double size = norm(exact);
  for (const double relative : {1e-1, 1e-4, 1e-10}) {
    const TensorTrain cut = rounded_hadamard(to_train(a), to_train(b), relative * size);
    CAPTURE(relative);
    CHECK(distance(cut, exact) <= relative * size);
    CHECK(cut.ranks() == rounded(exact, relative * size).ranks());
  }
}

TEST_CASE("contraction, restriction and a matrix act on any one mode of a train") {
  const SeparatedTensor a = random_tensor(kTrainSizes, 4, 5);
  const TensorTrain train = to_train(a);
  for (int mode = 0; mode < 4; ++mode) {
    const int n = kTrainSizes[static_cast<std::size_t>(mode)];
    const Eigen::VectorXd weights = random_matrix(n, 1, 6).col(0);
    const Eigen::MatrixXd matrix = random_matrix(6, n, 7);
    CAPTURE(mode);
    CHECK(difference(contracted(train, mode, weights), contracted(a, mode, weights)) < 1e-12);
    CHECK(difference(restricted(train, mode, n - 1), restricted(a, mode, n - 1)) < 1e-12);
    CHECK(difference(applied(train, mode, matrix), applied(a, mode, matrix)) < 1e-12);
    CHECK(difference(applied(train, mode, SparseMatrix(matrix.sparseView())), applied(a, mode, matrix)) <
          1e-12);
  }
}

TEST_CASE("the inner product of trains is symmetric, linear and bounded by the norms") {
  const TensorTrain a = to_train(random_tensor(kTrainSizes, 3, 8));
  const TensorTrain b = to_train(random_tensor(kTrainSizes, 4, 9));
  const TensorTrain c = to_train(random_tensor(kTrainSizes, 2, 10));
  CHECK(inner(a, b) == Approx(inner(b, a)));
  CHECK(inner(a, sum(b, c, 2.0)) == Approx(inner(a, b) + 2.0 * inner(a, c)));
  CHECK(std::abs(inner(a, b)) <= norm(a) * norm(b));
  CHECK(inner(a, a) == Approx(norm(a) * norm(a)));
}

TEST_CASE("trains that do not fit are refused with both sides named") {
  const TensorTrain a = to_train(random_tensor(kTrainSizes, 2, 11));
  const TensorTrain b = to_train(random_tensor({4, 3, 5}, 2, 12));
  CHECK_THROWS_AS(sum(a, b), samara::ArgumentError);
  CHECK_THROWS_WITH(sum(a, b), Contains("4 x 3 x 5 x 2") && Contains("4 x 3 x 5 nodes"));
  CHECK_THROWS_WITH(hadamard(a, b), Contains("product"));
  CHECK_THROWS_WITH(rounded_hadamard(a, b, 1e-3), Contains("product"));
  CHECK_THROWS_WITH(inner(a, b), Contains("inner product"));
  CHECK_THROWS_WITH(restricted(a, -1, 0), Contains("mode -1") && Contains("0 to 3"));
  CHECK_THROWS_WITH(restricted(a, 2, 5), Contains("index 5") && Contains("0 to 4"));
  CHECK_THROWS_WITH(contracted(a, 0, Eigen::VectorXd::Ones(3)), Contains("3 nodes") && Contains("has 4"));
  CHECK_THROWS_WITH(applied(a, 3, random_matrix(2, 3, 13)), Contains("3 nodes") && Contains("has 2"));
  CHECK_THROWS_WITH(restricted(to_train(random_tensor({4}, 2, 14)), 0, 1), Contains("only mode"));
}
