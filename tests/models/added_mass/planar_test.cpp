#include <numbers>

#include <catch2/catch.hpp>

#include "samara/models/added_mass/ellipsoid.h"
#include "samara/models/added_mass/planar_sections.h"

using namespace samara::models;
using Section = added_mass::SectionAddedMass<double>;
using Catch::Matchers::WithinRel;

TEST_CASE("the planar ellipse is the long limit of the ellipsoid, section by section") {
  // Sections of the ellipsoid shrink with sqrt(1-x^2/L^2): m integrates to 4/3 L, I_a to 16/15 L. End
  // effects (a/L)^2 log(L/a) = 1e-7.
  const double a = 3.0, b = 0.7, rho = 1.2, L = 3e4;
  const Section section = added_mass::ellipse_section(a, b, rho);
  const DiagonalAddedMass body = ellipsoid_added_mass({L, a, b}, rho);
  CHECK_THAT(body.mass[1], WithinRel(4.0 / 3.0 * L * section.m11, 1e-6));
  CHECK_THAT(body.mass[2], WithinRel(4.0 / 3.0 * L * section.m22, 1e-6));
  CHECK_THAT(body.inertia[0], WithinRel(16.0 / 15.0 * L * section.I_a, 1e-6));
}

TEST_CASE("a circle has the added mass of its own area and no added inertia") {
  const Section circle = added_mass::ellipse_section(0.5, 0.5, 4.0);
  CHECK_THAT(circle.m11, WithinRel(std::numbers::pi, 1e-15));
  CHECK_THAT(circle.m22, WithinRel(std::numbers::pi, 1e-15));
  CHECK(circle.I_a == 0.0);
  CHECK(added_mass::ellipse_section(0.5, 0.0, 4.0).m11 == 0.0);
}

TEST_CASE("the rectangular section follows its published coefficients") {
  const Section plate = added_mass::rectangle_section(2.0, 1.0, 8.0 / std::numbers::pi);
  CHECK_THAT(plate.m11, WithinRel(3.0, 1e-15));
  CHECK_THAT(plate.m22, WithinRel(12.0, 1e-15));
  CHECK_THAT(plate.I_a, WithinRel(45.0 / 32.0, 1e-15));
}
