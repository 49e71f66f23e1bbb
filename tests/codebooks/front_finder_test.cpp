#include "samara/codebooks/build/front_finder.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include <catch2/catch.hpp>

#include "samara/pgd/tensors/random.h"

// The place of fronts, of values of our own in the place of trajectories.

using namespace samara::codebooks;

namespace {

using Place = std::function<double(const Eigen::VectorXd& point)>;

constexpr double kWidth = 0.002;

/// Of tanh((x - place)/kWidth), and a wave beside it, over [-1, 1] x [0, 2] x ..: x is the last coordinate.
std::optional<FrontMap> found(const Place& place, Eigen::Index coordinates = 3, long max_points = 60'000) {
  const LineNodes::Values values = [&](const Eigen::MatrixXd& points) {
    Eigen::MatrixXd result(2, points.cols());
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      const double x = points(coordinates - 1, j);
      result(0, j) = std::tanh((x - place(points.col(j))) / kWidth);
      result(1, j) = std::sin(9.0 * x);
    }
    return result;
  };
  FrontFinderOptions options;
  options.lower = Eigen::VectorXd::Constant(coordinates, -1.0);
  options.upper = Eigen::VectorXd::Constant(coordinates, 1.0);
  options.lower[0] = 0.0;
  options.upper[0] = 2.0;
  options.max_points = max_points;
  return find_front(coordinates - 1, values, options);
}

double curved(const Eigen::VectorXd& point) {
  return 0.5 * std::sin(point[0]) - 0.2 * point[1] * point[1];
}

}  // namespace

TEST_CASE("the place of a front is found as a polynomial of the other coordinates") {
  const std::optional<FrontMap> map = found(curved);
  REQUIRE(map);
  CHECK(map->coordinate() == 2);
  samara::pgd::Random random(3);
  double worst = 0.0;
  for (int j = 0; j < 200; ++j) {
    const Eigen::Vector3d point(2.0 * random.uniform(), 2.0 * random.uniform() - 1.0, 0.7);
    worst = std::max(worst, std::abs(map->front_at(point.data()) - curved(point)));
  }
  CHECK(worst <= 0.2 * kWidth);
  CHECK(map->others().size() == 2);
}

TEST_CASE(
    "of a front that no affordable polynomial meets, the best one is taken if it errs by two widths at "
    "most") {
  const Place wavy = [](const Eigen::VectorXd& point) {
    return 0.2 * std::sin(2.2 * point[0] - 1.9) * std::cos(2.0 * point[1] + 0.2) *
           std::cos(2.0 * point[2] - 0.1);
  };
  const std::optional<FrontMap> map = found(wavy, 4);
  REQUIRE(map);
  samara::pgd::Random random(5);
  double worst = 0.0;
  for (int j = 0; j < 200; ++j) {
    const Eigen::Vector4d point(2.0 * random.uniform(), 2.0 * random.uniform() - 1.0,
                                2.0 * random.uniform() - 1.0, 0.7);
    worst = std::max(worst, std::abs(map->front_at(point.data()) - wavy(point)));
  }
  CHECK(worst > 0.1 * kWidth);
  CHECK(worst < 4.0 * kWidth);  // twice what 24 lines may show
}

TEST_CASE("there is no place of a front that comes near an end, has an edge, or takes too much to find") {
  CHECK_FALSE(found([](const Eigen::VectorXd& point) { return 0.5 * point[0]; }));
  CHECK_FALSE(found([](const Eigen::VectorXd& point) { return 0.5 * std::abs(point[1]); }));
  CHECK_FALSE(found(curved, 3, 10'000));
  CHECK_FALSE(found(curved, 6));
  CHECK_FALSE(found([](const Eigen::VectorXd&) { return 0.1; }, 1));
  const LineNodes::Values constant = [](const Eigen::MatrixXd& points) -> Eigen::MatrixXd {
    return Eigen::MatrixXd::Ones(1, points.cols());
  };
  FrontFinderOptions options;
  options.lower = Eigen::Vector2d(-1.0, -1.0);
  options.upper = Eigen::Vector2d(1.0, 1.0);
  CHECK_FALSE(find_front(0, constant, options));
}
