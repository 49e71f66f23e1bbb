#include "samara/pgd/fields/error_scale.h"

#include <limits>

#include <catch2/catch.hpp>

using namespace samara::pgd;

TEST_CASE("errors are divided by the range, at least by its floor") {
  CHECK(error_scale({.range = 2.0, .size = 5.0}) == 2.0);
  CHECK(error_scale({.range = 2.0, .floor = 3.0, .size = 5.0}) == 3.0);
  CHECK(error_scale({.range = 2e-3, .size = 1e6}) == 2e-3);
}

TEST_CASE("a range that is the rounding of a constant is none: its size counts, or one") {
  constexpr double kEps = std::numeric_limits<double>::epsilon();
  CHECK(error_scale({.range = 4.0 * kEps, .size = 3.0}) == 3.0);
  CHECK(error_scale({.range = 4.0 * kEps, .floor = 1e-3, .size = 3.0}) == 1e-3);
  CHECK(error_scale({}) == 1.0);
  CHECK(error_scale({.floor = 1e-3}) == 1e-3);
}

TEST_CASE("what is nothing beside the size that is declared is nothing") {
  const Eigen::VectorXd noise = Eigen::Vector2d(2.5e-20, 3.0);
  CHECK(error_scales(-noise, noise, {.sizes = Eigen::Vector2d(0.1, 0.1)}) == Eigen::Vector2d(0.1, 6.0));
  CHECK(error_scales(-noise, noise, {}) == Eigen::Vector2d(5e-20, 6.0));
}
