#include "samara/pgd/tensors/compression.h"

#include <cmath>

#include <Eigen/SVD>
#include <catch2/catch.hpp>

#include "random_tensor.h"
#include "samara/pgd/tensors/tensor_train.h"

using namespace samara::pgd;

namespace {

/// || a - b || entry by entry, on a small grid.
double distance(const SeparatedTensor& a, const SeparatedTensor& b) {
  double sum = 0.0;
  for_every_entry(a.sizes(), [&](const std::vector<int>& index) {
    const double difference = a.entry(index) - b.entry(index);
    sum += difference * difference;
  });
  return std::sqrt(sum);
}

/// Terms that fall like 10^-r: there is something to leave out at every tolerance.
SeparatedTensor decaying(const std::vector<int>& sizes, int rank, std::uint64_t seed) {
  SeparatedTensor tensor = random_tensor(sizes, rank, seed);
  tensor.normalise();
  for (int r = 0; r < tensor.rank(); ++r) tensor.weights[r] = std::pow(10.0, -r);
  return tensor;
}

const std::vector<std::vector<int>> kGrids = {{9, 11},         {7, 6, 8},    {4, 5, 6, 5},
                                              {3, 4, 5, 4, 3}, {1, 6, 1, 7}, {12}};

}  // namespace

TEST_CASE("compression keeps to its tolerance and reports its error") {
  for (const std::vector<int>& sizes : kGrids) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const SeparatedTensor tensor = seed % 2 == 0 ? decaying(sizes, 7, seed) : random_tensor(sizes, 5, seed);
      const double size = norm(tensor);
      for (const double relative : {0.5, 1e-2, 1e-4, 1e-8}) {
        const CompressionResult result = compress(tensor, relative * size);
        CAPTURE(sizes, seed, relative);
        CHECK(result.tolerance_met);
        CHECK(result.error <= relative * size);
        CHECK(result.tensor.rank() <= tensor.rank());
        // Two independent sums: round-off of entries of the tensor's size.
        CHECK(distance(result.tensor, tensor) == Approx(result.error).margin(1e-13 * size));
      }
    }
  }
}

TEST_CASE("a tensor added to itself, or a term taken apart, keeps its rank") {
  for (const std::vector<int>& sizes : {std::vector<int>{9, 11}, {7, 6, 8}, {4, 5, 6, 5}, {3, 4, 5, 4, 3}}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const SeparatedTensor tensor = random_tensor(sizes, 3, 20 + seed);
      SeparatedTensor twice = tensor;
      twice.append(tensor, 0.7);
      // One factor of every term as a sum of two, which doubles the terms.
      SeparatedTensor parts = tensor;
      const SeparatedTensor other = random_tensor(sizes, 3, 40 + seed);
      parts.append(tensor);
      parts.factors[1].rightCols(3) = other.factors[1];
      parts.factors[1].leftCols(3) -= other.factors[1];
      for (const SeparatedTensor& redundant : {twice, parts}) {
        const CompressionResult result = compress(redundant, 1e-8 * norm(redundant));
        CAPTURE(sizes, seed);
        CHECK(result.tensor.rank() == 3);
        CHECK(result.tolerance_met);
      }
    }
  }
}

TEST_CASE("with two nontrivial modes the rank is the one of the singular value decomposition") {
  for (const std::vector<int>& sizes : {std::vector<int>{12, 15}, {12, 1, 15}, {1, 12, 1, 1, 15, 1}}) {
    const SeparatedTensor tensor = decaying(sizes, 9, 60);
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(12, 15);
    std::size_t row = sizes[0] == 1 ? 1 : 0;
    std::size_t col = sizes[0] == 1 ? 4 : sizes.size() - 1;
    for_every_entry(
        sizes, [&](const std::vector<int>& index) { matrix(index[row], index[col]) = tensor.entry(index); });
    const Eigen::VectorXd sigma = matrix.jacobiSvd().singularValues();
    for (const double tolerance : {1e-1, 1e-3, 1e-5, 1e-9}) {
      const CompressionResult result = compress(tensor, tolerance);
      // Least rank for a tolerance: the tail of the singular values. The result uses between half of the
      // tolerance, over the cuts of the train, and all of it.
      const auto least = [&](double allowed) {
        int rank = 12;
        while (rank > 0 && sigma.tail(12 - rank + 1).norm() <= allowed) --rank;
        return rank;
      };
      CAPTURE(sizes, tolerance, sigma.transpose());
      CHECK(result.tensor.rank() >= least(tolerance));
      CHECK(result.tensor.rank() <=
            least(0.5 * tolerance / std::sqrt(static_cast<double>(sizes.size()) - 1.0)));
      // The error cannot be below that of the best tensor of its rank.
      CHECK(result.error >= sigma.tail(12 - result.tensor.rank()).norm() * (1.0 - 1e-6) - 1e-14);
    }
  }
}

TEST_CASE("sums with fewer terms than the train has chains are found") {
  // Rank 4 in four modes: the train (4, 4, 4) expands to 64 products.
  const SeparatedTensor tensor = random_tensor({6, 7, 8, 6}, 4, 70);
  const CompressionResult result = compress(tensor, 1e-6 * norm(tensor));
  CHECK(result.tolerance_met);
  CHECK(result.tensor.rank() == 4);
}

TEST_CASE("zero stays zero and what is below the tolerance vanishes") {
  const std::vector<int> sizes = {4, 5, 6};
  for (const CompressionResult& result :
       {compress(SeparatedTensor::zero(sizes), 1e-6), compress(random_tensor(sizes, 3, 80), 1e9)}) {
    CHECK(result.tensor.rank() == 0);
    CHECK(result.tensor.sizes() == sizes);
    CHECK(result.tolerance_met);
  }
  SeparatedTensor nothing = random_tensor(sizes, 3, 81);
  nothing.append(nothing, -1.0);
  const CompressionResult result = compress(nothing, 1e-9);
  CHECK(result.tensor.rank() == 0);
  CHECK(result.error < 1e-12);
}

TEST_CASE("an impossible tolerance is reported as missed") {
  const SeparatedTensor tensor = random_tensor({6, 7, 8}, 3, 90);
  const CompressionResult result = compress(tensor, 1e-300);
  CHECK_FALSE(result.tolerance_met);
  CHECK(result.error < 1e-13 * norm(tensor));
}
