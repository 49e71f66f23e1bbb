#include "samara/codebooks/book/sobol_points.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

using samara::codebooks::sobol_points;

namespace {

/// Whether all numbers 0 .. count - 1 are there, each once.
bool is_permutation_of_all(std::vector<int> cells, int count) {
  std::sort(cells.begin(), cells.end());
  for (int i = 0; i < count; ++i) {
    if (cells[static_cast<std::size_t>(i)] != i) return false;
  }
  return static_cast<int>(cells.size()) == count;
}

}  // namespace

TEST_CASE("every coordinate of the first 2^m points falls once into each interval of length 2^-m") {
  for (const std::uint64_t seed : {1u, 2u, 2026u}) {
    const Eigen::MatrixXd points = sobol_points(12, 4096, seed);
    for (int m = 0; m <= 12; ++m) {
      const int count = 1 << m;
      for (Eigen::Index k = 0; k < points.rows(); ++k) {
        std::vector<int> cells;
        for (Eigen::Index j = 0; j < count; ++j) cells.push_back(static_cast<int>(points(k, j) * count));
        CAPTURE(seed, m, k);
        CHECK(is_permutation_of_all(cells, count));
      }
    }
  }
}

TEST_CASE("the first two coordinates of 2^m points fall once into each box of 2^-a by 2^-(m-a)") {
  // Sobol' points in two dimensions are a (0,2)-sequence (Sobol' 1967), and nested scrambling keeps that
  // (Owen 1995).
  const Eigen::MatrixXd points = sobol_points(2, 1024, 5);
  for (int m = 0; m <= 10; ++m) {
    for (int a = 0; a <= m; ++a) {
      std::vector<int> cells;
      for (Eigen::Index j = 0; j < (1 << m); ++j) {
        cells.push_back((static_cast<int>(points(0, j) * (1 << a)) << (m - a)) +
                        static_cast<int>(points(1, j) * (1 << (m - a))));
      }
      CAPTURE(m, a);
      CHECK(is_permutation_of_all(cells, 1 << m));
    }
  }
}

TEST_CASE("points lie in the unit cube, 1 excluded, and none is repeated") {
  const Eigen::MatrixXd points = sobol_points(3, 5000, 3);
  CHECK(points.rows() == 3);
  CHECK(points.cols() == 5000);
  CHECK(points.minCoeff() >= 0.0);
  CHECK(points.maxCoeff() < 1.0);
  std::vector<double> first(points.row(0).begin(), points.row(0).end());
  std::sort(first.begin(), first.end());
  CHECK(std::adjacent_find(first.begin(), first.end()) == first.end());
}

TEST_CASE("means tend to one half like 1/N") {
  // One point in each of N equal cells: each is at most 1/(2N) from the middle of its cell.
  for (int count = 2; count <= 8192; count *= 4) {
    const Eigen::MatrixXd points = sobol_points(6, count, 9);
    for (Eigen::Index k = 0; k < 6; ++k) CHECK(std::abs(points.row(k).mean() - 0.5) <= 0.5 / count);
  }
}

TEST_CASE("the same seed gives the same points, more of them begin with the fewer") {
  const Eigen::MatrixXd points = sobol_points(4, 1000, 42);
  CHECK(points == sobol_points(4, 1000, 42));
  CHECK(points.leftCols(300) == sobol_points(4, 300, 42));
  CHECK(points.topRows(2).leftCols(100) == sobol_points(2, 100, 42));
}

TEST_CASE("another seed gives other points, on average uncorrelated with the first") {
  // Every pair of seeds flips the leading bits of all points alike, so that one correlation may be anything
  // from -1 to 1; but flips are random, and the mean over many pairs is within a few 1/sqrt(pairs) of zero.
  constexpr int kPairs = 200;
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= kPairs; ++seed) {
    const Eigen::ArrayXXd a = sobol_points(1, 256, seed).array() - 0.5;
    const Eigen::ArrayXXd b = sobol_points(1, 256, seed + 1000).array() - 0.5;
    CHECK((a - b).abs().maxCoeff() > 1e-3);
    sum += 12.0 * (a * b).mean();
  }
  CHECK(std::abs(sum / kPairs) < 4.0 / std::sqrt(kPairs));
}

TEST_CASE("coordinates of one set are scrambled independently") {
  const Eigen::ArrayXXd points = sobol_points(8, 4096, 17).array() - 0.5;
  // A product rule integrates x_j x_k to about 1/N^(3/2) (Owen 1997): far below 1e-2.
  for (Eigen::Index j = 0; j < 8; ++j) {
    for (Eigen::Index k = 0; k < j; ++k) CHECK(std::abs((points.row(j) * points.row(k)).mean()) < 1e-3);
  }
}

TEST_CASE("beyond the dimensions that there are direction numbers for, points are plain random ones") {
  constexpr Eigen::Index kKnown = 3667;
  const Eigen::MatrixXd points = sobol_points(3700, 64, 7);
  CHECK(points.topRows(kKnown) == sobol_points(kKnown, 64, 7));
  CHECK(points.leftCols(16) == sobol_points(3700, 16, 7));
  const Eigen::MatrixXd beyond = points.bottomRows(3700 - kKnown);
  CHECK(beyond.minCoeff() >= 0.0);
  CHECK(beyond.maxCoeff() < 1.0);
  // 33 x 64 numbers of variance 1/12: four deviations of their mean.
  CHECK(std::abs(beyond.mean() - 0.5) < 4.0 / std::sqrt(12.0 * static_cast<double>(beyond.size())));
}
