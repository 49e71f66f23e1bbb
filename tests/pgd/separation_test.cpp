#include "samara/pgd/tensors/separation.h"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "random_tensor.h"
#include "samara/base/errors.h"
#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/tensors/compression.h"
#include "samara/pgd/tensors/tensor_algebra.h"
#include "samara/pgd/tensors/train_algebra.h"

using namespace samara::pgd;
using Catch::Contains;
using samara::Termination;

namespace {

/// A train with normal entries: nothing in it can be left out.
TensorTrain random_train(const std::vector<int>& sizes, int rank, std::uint64_t seed) {
  Random random(seed);
  TensorTrain train;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    TrainCore core(k == 0 ? 1 : rank, sizes[k], k + 1 == sizes.size() ? 1 : rank);
    for (double& value : core.data) value = random.normal();
    train.cores.push_back(std::move(core));
  }
  return train;
}

/// 1 / (1 + sum of x) on [0, 1]^d.
TensorTrain smooth_train(int modes, int nodes) {
  const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
    const Eigen::MatrixXd x = entries.cast<double>() / (nodes - 1.0);
    values.row(0) = (1.0 + x.colwise().sum().array()).inverse();
  };
  CrossOptions options;
  options.tolerance = 1e-10;
  const CrossResult result =
      interpolate(function, 1, std::vector<int>(static_cast<std::size_t>(modes), nodes), options);
  REQUIRE(result.status == Termination::converged);
  return result.train;
}

}  // namespace

TEST_CASE("a train of twenty terms in six modes is separated without its three million chains") {
  const SeparatedTensor tensor = random_tensor({20, 21, 22, 20, 21, 20}, 20, 1);
  const TensorTrain train = to_train(tensor);
  const double size = norm(train);
  CHECK_THROWS_AS(to_separated(train), samara::ArgumentError);
  CHECK_THROWS_WITH(to_separated(train),
                    Contains("20, 20, 20, 20, 20") && Contains("3.2e+06") && Contains("separate()"));
  const Separation result = separate(train, 1e-6 * size);
  CAPTURE(result.message);
  CHECK(result.status == Termination::converged);
  CHECK(result.tensor.rank() == 20);
  CHECK(result.error <= 1e-6 * size);
  CHECK(distance(to_train(result.tensor), train) == Approx(result.error));
}

TEST_CASE("a train that no short sum holds is refused with its numbers") {
  const TensorTrain train = random_train({8, 8, 8, 8, 8}, 8, 2);
  const double size = norm(train);
  const Separation result = separate(train, 1e-3 * size, 300);
  CHECK(result.status == Termination::rank_limit);
  CHECK(result.chains == 4096.0);
  CHECK(result.tensor.rank() <= 300);
  // What is returned is still the best sum found, and its error is the measured one.
  CHECK(result.error > 1e-3 * size);
  CHECK(result.error < size);
  CHECK(distance(to_train(result.tensor), train) == Approx(result.error));
  CHECK_THAT(result.message, Contains("300 allowed") && Contains("4.1e+03 products"));
  // With enough terms allowed the expansion itself is the answer.
  const Separation all = separate(train, 1e-12 * size, 4096);
  CAPTURE(all.message);
  CHECK(all.status == Termination::converged);
  CHECK(all.expanded);
}

TEST_CASE("smooth functions of five coordinates are separated to their tolerance in few terms") {
  const TensorTrain train = smooth_train(5, 10);
  const double size = norm(train);
  for (const double relative : {1e-3, 1e-5}) {
    const Separation result = separate(train, relative * size);
    CAPTURE(relative, result.message);
    CHECK(result.status == Termination::converged);
    CHECK(result.error <= relative * size);
    // Exponential sums (Braess and Hackbusch 2005) for 1/x on [1, 6] give 1e-3 with 3 terms, 1e-5 with 5 in
    // the maximum norm; local minima of the fit cost a few more.
    CHECK(result.tensor.rank() <= (relative > 1e-4 ? 6 : 14));
  }
}

TEST_CASE("separation keeps to its tolerance on random trains, for all numbers of modes") {
  for (int modes = 1; modes <= 4; ++modes) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const std::vector<int> sizes(static_cast<std::size_t>(modes), 5);
      const TensorTrain train = random_train(sizes, 3, 10 * seed);
      const double size = norm(train);
      for (const double relative : {0.3, 1e-2, 1e-9}) {
        const Separation result = separate(train, relative * size);
        CAPTURE(modes, seed, relative, result.message);
        CHECK(result.status == Termination::converged);
        CHECK(result.error <= relative * size);
        CHECK(result.tensor.rank() <= result.chains);
      }
    }
  }
}

TEST_CASE("the zero train has no terms and a large tolerance leaves none") {
  const TensorTrain zero = to_train(SeparatedTensor::zero(std::vector<int>{4, 5, 6}));
  CHECK(separate(zero, 0.0).tensor.rank() == 0);
  CHECK(separate(zero, 0.0).status == Termination::converged);
  const TensorTrain train = random_train({4, 5, 6}, 2, 3);
  CHECK(separate(train, 2.0 * norm(train)).tensor.rank() == 0);
}

TEST_CASE("sums with noise compress to the number of terms they were made of") {
  for (const std::vector<int>& sizes : {std::vector<int>{10, 10, 10}, {12, 12, 12, 12}, {8, 8, 8, 8, 8}}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      constexpr int kTerms = 6;
      const SeparatedTensor tensor = random_tensor(sizes, kTerms, seed);
      SeparatedTensor noisy = tensor;
      const SeparatedTensor noise = random_tensor(sizes, 3 * kTerms, seed + 100);
      const double tolerance = 1e-4 * norm(tensor);
      noisy.append(noise, 0.3 * tolerance / norm(noise));
      const CompressionResult result = compress(noisy, tolerance);
      CAPTURE(sizes, seed);
      CHECK(result.tolerance_met);
      CHECK(result.tensor.rank() <= kTerms);
      CHECK(norm(sum(result.tensor, noisy, -1.0)) == Approx(result.error));
    }
  }
}

TEST_CASE("separation of nothing, or to a tolerance that is none, is refused") {
  const TensorTrain train = random_train({4, 5}, 2, 4);
  CHECK_THROWS_WITH(separate(TensorTrain{}, 1e-3), Contains("number of modes is 0"));
  CHECK_THROWS_AS(separate(train, -1.0), samara::ArgumentError);
  CHECK_THROWS_AS(separate(train, std::numeric_limits<double>::quiet_NaN()), samara::ArgumentError);
  CHECK_THROWS_WITH(separate(train, 1e-3, -2), Contains("max_terms is -2"));
}
