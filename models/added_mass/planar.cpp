#include "samara/models/added_mass/planar.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/positive.h"

namespace samara::models {

namespace {

using std::numbers::pi;

void require_section(double chord, double thickness, double fluid_density, const char* where) {
  require_positive(chord, "chord a [m]", where);
  require_positive(fluid_density, "fluid density [kg/m^3]", where);
  if (!std::isfinite(thickness) || thickness < 0.0) {
    throw ArgumentError(
        fmt::format("{}: thickness b [m] is {}; a positive number or 0 is needed", where, thickness));
  }
}

/// (a^2 - b^2)^2 without cancellation.
double squared_difference_of_squares(double a, double b) {
  const double d = (a - b) * (a + b);
  return d * d;
}

}  // namespace

PlanarAddedMass planar_ellipse_added_mass(double a, double b, double fluid_density) {
  require_section(a, b, fluid_density, "planar_ellipse_added_mass");
  return {.m11 = pi * fluid_density * b * b,
          .m22 = pi * fluid_density * a * a,
          .I_a = pi / 8.0 * fluid_density * squared_difference_of_squares(a, b)};
}

PlanarAddedMass planar_rectangle_added_mass(double a, double b, double fluid_density) {
  require_section(a, b, fluid_density, "planar_rectangle_added_mass");
  return {.m11 = 3.0 * pi / 8.0 * fluid_density * b * b,
          .m22 = 3.0 * pi / 8.0 * fluid_density * a * a,
          .I_a = 5.0 * pi / 256.0 * fluid_density * squared_difference_of_squares(a, b)};
}

}  // namespace samara::models
