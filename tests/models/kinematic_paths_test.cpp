// Model sheet, section 6: the paths of (3.6)-(3.10).
#include "samara/models/bodies/kinematic_paths.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

const SideToSidePath kLeaf = {.x0 = 0.1,
                              .z0 = 2.0,
                              .descent_speed = 0.4,
                              .horizontal_speed = 0.8,
                              .vertical_speed = 0.3,
                              .angular_frequency = 6.0};
const RosePath kHelix = {.z0 = 2.0,
                         .descent_speed = 0.4,
                         .amplitude_x = 0.2,
                         .amplitude_y = 0.15,
                         .modulation = 0.3,
                         .lobes = 4.0,
                         .angular_frequency = 6.0};

/// Central differences over h = 1e-5 of times of 1/24 s: truncation (4 W h)^2/6 ~ 1e-8 of a speed near 3, and
/// round-off eps/h ~ 1e-11.
template <class Path>
void check_velocity(const Path& path) {
  const double h = 1e-5;
  for (int k = 0; k < 50; ++k) {
    const double t = 0.037 * k;
    const Eigen::Vector3d difference = (at(path, t + h).position - at(path, t - h).position) / (2.0 * h);
    CHECK((at(path, t).velocity - difference).cwiseAbs().maxCoeff() < 1e-7);
  }
}

}  // namespace

TEST_CASE("the velocities of paths are the derivatives of their positions") {
  check_velocity(kLeaf);
  check_velocity(kHelix);
}

TEST_CASE("the amplitudes of (3.6) are those of the horizontal and of the vertical velocity") {
  double fastest_x = 0.0, fastest_z = 0.0, slowest_z = -10.0;
  for (int k = 0; k <= 1000; ++k) {
    const PathPoint point = at(kLeaf, k * std::numbers::pi / 3000.0);  // one period
    fastest_x = std::max(fastest_x, std::abs(point.velocity.x()));
    fastest_z = std::min(fastest_z, point.velocity.z());
    slowest_z = std::max(slowest_z, point.velocity.z());
    CHECK(point.position.y() == 0.0);
  }
  CHECK_THAT(fastest_x, WithinRel(0.8, 1e-5));
  CHECK_THAT(fastest_z, WithinRel(-0.7, 1e-5));
  CHECK_THAT(slowest_z, WithinRel(-0.1, 1e-4));
}

TEST_CASE("without modulation a rose is a circle, whatever its lobes") {
  for (const double lobes : {1.0, 3.0, 4.0}) {
    RosePath path = kHelix;
    path.amplitude_y = path.amplitude_x;
    path.modulation = 0.0;
    path.lobes = lobes;
    for (int k = 0; k < 20; ++k) {
      const PathPoint point = at(path, 0.1 * k);
      CHECK_THAT(point.position.head<2>().norm(), WithinRel(0.2, 1e-14));
      CHECK_THAT(point.velocity.head<2>().norm(), WithinRel(1.2, 1e-14));
    }
  }
}

TEST_CASE("without amplitude a rose is steady descent, with one alone a straight line") {
  RosePath path = kHelix;
  path.amplitude_y = 0.0;
  for (int k = 0; k < 20; ++k) CHECK(at(path, 0.1 * k).position.y() == 0.0);
  path.amplitude_x = 0.0;
  for (int k = 0; k < 20; ++k) {
    const PathPoint point = at(path, 0.1 * k);
    CHECK(point.position.head<2>().norm() == 0.0);
    CHECK_THAT(point.position.z(), WithinAbs(2.0 - 0.04 * k, 1e-15));
    CHECK(point.velocity.z() == -0.4);
  }
}

TEST_CASE("a rose of k = 4 has four lobes, and eight petals only for a modulation beyond one") {
  const auto maxima_of_radius = [](double modulation) {
    RosePath path = kHelix;
    path.amplitude_y = path.amplitude_x;
    path.modulation = modulation;
    const int n = 10000;  // times of one revolution
    std::vector<double> radius;
    for (int k = 0; k < n; ++k) {
      radius.push_back(at(path, 2.0 * std::numbers::pi / 6.0 * k / n).position.head<2>().norm());
    }
    int maxima = 0;
    for (std::size_t k = 0; k < radius.size(); ++k) {
      const double before = radius[(k + radius.size() - 1) % radius.size()];
      const double after = radius[(k + 1) % radius.size()];
      if (radius[k] > before && radius[k] >= after) ++maxima;
    }
    return maxima;
  };
  CHECK(maxima_of_radius(0.3) == 4);
  CHECK(maxima_of_radius(0.9) == 4);
  CHECK(maxima_of_radius(1.5) == 8);
}

TEST_CASE("paths refuse numbers without meaning") {
  RosePath path = kHelix;
  path.modulation = std::nan("");
  CHECK_THROWS_WITH(at(path, 0.0), "modulation is nan; a finite number was expected");
  path = kHelix;
  path.angular_frequency = 0.0;
  CHECK_THROWS_WITH(at(path, 0.0), "angular_frequency is 0; a positive finite number was expected");
  CHECK_THROWS_AS(at(kHelix, std::numeric_limits<double>::infinity()), samara::ArgumentError);
}
