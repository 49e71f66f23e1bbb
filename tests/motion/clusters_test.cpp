#include "samara/motion/patterns/clusters.h"

#include <catch2/catch.hpp>

#include "samara/base/streams.h"
#include "samara/motion/patterns/agreement.h"
#include "tests/error_text.h"

using namespace samara::motion;

namespace {

struct Cloud {
  Eigen::MatrixXd points;
  std::vector<int> kinds;
};

/// Three clouds of 100 points with deviations (1, spread) at (0, 0), (10, 0) and (0, 10 spread).
Cloud clouds(double spread) {
  Cloud all;
  all.points.resize(300, 2);
  samara::Stream stream(1, 0);
  for (Eigen::Index n = 0; n < 300; ++n) {
    const auto kind = static_cast<int>(n / 100);
    all.kinds.push_back(kind);
    all.points(n, 0) = (kind == 1 ? 10.0 : 0.0) + stream.normal();
    all.points(n, 1) = spread * ((kind == 2 ? 10.0 : 0.0) + stream.normal());
  }
  return all;
}

}  // namespace

TEST_CASE("k-means and mixtures find clouds that lie apart, and say how they ended") {
  const Cloud all = clouds(1.0);
  for (const Clusters& found :
       {k_means(all.points, {.clusters = 3}), gaussian_mixture(all.points, {.clusters = 3})}) {
    CHECK(adjusted_rand(all.kinds, found.assignment) == Approx(1.0));
    CHECK(found.converged);
    CHECK(found.message.find("settled after") == 0);
    for (Eigen::Index c = 0; c < 3; ++c) CHECK(found.centres.row(c).norm() < 10.5);
  }
}

TEST_CASE(
    "k-means never raises its sum of squares, and expectation-maximisation never lowers its likelihood") {
  Eigen::MatrixXd points(400, 3);
  samara::Stream stream(2, 0);
  for (double& value : points.reshaped()) value = stream.uniform();
  const Clusters near = k_means(points, {.clusters = 6});
  for (std::size_t k = 1; k < near.history.size(); ++k)
    CHECK(near.history[k] <= near.history[k - 1] * (1.0 + 1e-12));
  const Clusters mixed = gaussian_mixture(points, {.clusters = 4, .restarts = 2});
  for (std::size_t k = 1; k < mixed.history.size(); ++k)
    CHECK(mixed.history[k] >= mixed.history[k - 1] - 1e-5);
}

TEST_CASE("mixtures follow clouds that are long and thin where k-means cuts them") {
  // Two lines of deviation 10 that lie 2 apart, 0.1 wide.
  Eigen::MatrixXd points(400, 2);
  std::vector<int> kinds;
  samara::Stream stream(3, 0);
  for (Eigen::Index n = 0; n < 400; ++n) {
    kinds.push_back(static_cast<int>(n % 2));
    points.row(n) << 10.0 * stream.normal(), 2.0 * static_cast<double>(n % 2) + 0.1 * stream.normal();
  }
  CHECK(adjusted_rand(kinds, k_means(points, {.clusters = 2}).assignment) < 0.1);
  CHECK(adjusted_rand(kinds, gaussian_mixture(points, {.clusters = 2, .restarts = 30}).assignment) > 0.95);
}

TEST_CASE("clusters are the same for the same seed, and numbered by size") {
  Eigen::MatrixXd points(50, 1);
  for (Eigen::Index n = 0; n < 50; ++n) points(n, 0) = n < 10 ? 0.0 : 5.0;
  const Clusters found = k_means(points, {.clusters = 2});
  CHECK(found.assignment.front() == 1);
  CHECK(found.centres(0, 0) == 5.0);
  const Cloud all = clouds(1.0);
  CHECK(gaussian_mixture(all.points, {.seed = 5}).assignment ==
        gaussian_mixture(all.points, {.seed = 5}).assignment);
}

TEST_CASE("clusters beyond the points that differ have none, lie where points are, and are told") {
  Eigen::MatrixXd points(8, 2);
  for (Eigen::Index n = 0; n < 8; ++n) points.row(n) << (n < 5 ? 3.0 : 5.0), 7.0;
  const Eigen::MatrixXd alike = points.topRows(5);
  for (const auto& find : {k_means, gaussian_mixture}) {
    const Clusters some = find(points, {.clusters = 4}), one = find(alike, {.clusters = 3});
    CHECK(some.assignment == std::vector<int>{0, 0, 0, 0, 0, 1, 1, 1});
    CHECK(some.message.ends_with("iterations; 2 of 4 clusters have no points"));
    CHECK(one.assignment == std::vector<int>(5, 0));
    CHECK(one.message.ends_with("iterations; 2 of 3 clusters have no points"));
    for (const Clusters& found : {some, one}) {
      CHECK(std::isfinite(found.objective));
      for (Eigen::Index c = 0; c < found.centres.rows(); ++c) {
        const auto distances = (points.rowwise() - found.centres.row(c)).rowwise().norm();
        CHECK(distances.minCoeff() < 1e-6);
      }
    }
  }
}

TEST_CASE("standardised columns have mean 0 and deviation 1, or do not vary") {
  Eigen::MatrixXd points(4, 2);
  points << 1, 7, 2, 7, 3, 7, 6, 7;
  const Eigen::MatrixXd scaled = standardised(points);
  CHECK(scaled.col(0).mean() == Approx(0.0).margin(1e-12));
  CHECK(scaled.col(0).squaredNorm() / 4.0 == Approx(1.0));
  CHECK(scaled.col(1).isZero());
}

TEST_CASE("clusterings that cannot be meant are refused") {
  const Eigen::MatrixXd points = Eigen::MatrixXd::Zero(3, 2);
  CHECK(error_text<samara::ArgumentError>([&] {
          k_means(points, {.clusters = 4});
        }).find("there are 3 points for 4 clusters") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([&] {
          gaussian_mixture(points, {.clusters = 0});
        }).find("clusters is 0") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([&] {
          k_means(Eigen::MatrixXd(15, 0), {.clusters = 2});
        }).find("have no feature") != std::string::npos);
  Eigen::MatrixXd bad = points;
  bad(1, 1) = NAN;
  CHECK(error_text<samara::ArgumentError>([&] { k_means(bad, {.clusters = 2}); }).find("not finite") !=
        std::string::npos);
  bad(1, 1) = -1e160;  // its square overflows
  CHECK(error_text<samara::ArgumentError>([&] {
          gaussian_mixture(bad, {.clusters = 2});
        }).find("a number of size 1e+160, expected at most 1e+60") != std::string::npos);
}
