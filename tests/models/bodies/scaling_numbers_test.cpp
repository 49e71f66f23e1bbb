#include "samara/models/bodies/scaling_numbers.h"

#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::models;
using Catch::Matchers::WithinRel;

TEST_CASE("an aluminium disc in water has its scaling numbers, (3.1)-(3.3)") {
  // d = 2 cm, t = 1.5 mm; the dissertation prints 1e-2 and 3.55e3.
  CHECK_THAT(inertia_ratio_of_disc(2700.0, 1000.0, 0.02, 0.0015), WithinRel(0.009940195505498954, 1e-12));
  CHECK_THAT(fall_reynolds_number(2700.0, 1000.0, 0.02, 0.0015, 1.0e-6), WithinRel(3163.26, 2e-6));
  CHECK_THAT(fall_reynolds_number(2700.0, 1000.0, 0.02, 0.0015, 0.89e-6), WithinRel(3554.0, 1e-3));
}

TEST_CASE("bodies lighter than the fluid rise as fast as their buoyancy says") {
  CHECK_THAT(fall_speed_scale(500.0, 1000.0, 0.01), WithinRel(fall_speed_scale(1500.0, 1000.0, 0.01), 1e-15));
  CHECK_THAT(fall_speed_scale(2000.0, 1000.0, 0.01, 10.0), WithinRel(std::sqrt(0.1), 1e-15));
}

TEST_CASE("the inertia ratio of a plate is 32 I'/(pi rho_f l^4) with its moment of inertia per unit span") {
  const double rho_s = 2700.0, rho_f = 1000.0, l = 0.05, t = 0.004;
  const double I = rho_s * l * t * (l * l + t * t) / 12.0;
  CHECK_THAT(inertia_ratio_of_plate(rho_s, rho_f, l, t),
             WithinRel(32.0 * I / (std::numbers::pi * rho_f * std::pow(l, 4)), 1e-14));
}

TEST_CASE("the three inertia ratios depend on shape and densities alone, and refuse what has no size") {
  CHECK_THAT(inertia_ratio_of_ellipse(2700.0, 1000.0, 0.07, 0.005), WithinRel(2.7 / 14.0, 1e-14));
  CHECK_THAT(inertia_ratio_of_disc(2.7, 1.0, 2.0, 0.15),
             WithinRel(inertia_ratio_of_disc(2700.0, 1000.0, 0.02, 0.0015), 1e-14));
  CHECK_THAT(inertia_ratio_of_plate(2.7, 1.0, 2.0, 0.15),
             WithinRel(inertia_ratio_of_plate(2700.0, 1000.0, 0.02, 0.0015), 1e-14));
  CHECK_THROWS_AS(inertia_ratio_of_plate(2700.0, 1000.0, 0.02, 0.0), samara::ArgumentError);
  CHECK_THROWS_AS(fall_reynolds_number(2700.0, 1000.0, 0.02, 0.001, -1e-6), samara::ArgumentError);
  CHECK_THROWS_AS(inertia_ratio_of_ellipse(0.0, 1.0, 1.0, 1.0), samara::ArgumentError);
  CHECK_THROWS_AS(inertia_ratio_of_disc(1.0, std::nan(""), 1.0, 1.0), samara::ArgumentError);
}
