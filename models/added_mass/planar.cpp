#include "samara/models/added_mass/planar.h"

#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/added_mass/planar_sections.h"
#include "samara/models/positive.h"

namespace samara::models {

namespace {

void require_section(double chord, double thickness, double fluid_density, const char* where) {
  require_positive(chord, "chord a [m]", where);
  require_positive(fluid_density, "fluid density [kg/m^3]", where);
  if (!std::isfinite(thickness) || thickness < 0.0) {
    throw ArgumentError(
        fmt::format("{}: thickness b [m] is {}; a positive number or 0 is needed", where, thickness));
  }
}

PlanarAddedMass planar(const added_mass::SectionAddedMass<double>& section) {
  return {.m11 = section.m11, .m22 = section.m22, .I_a = section.I_a};
}

}  // namespace

PlanarAddedMass planar_ellipse_added_mass(double a, double b, double fluid_density) {
  require_section(a, b, fluid_density, "planar_ellipse_added_mass");
  return planar(added_mass::ellipse_section(a, b, fluid_density));
}

PlanarAddedMass planar_rectangle_added_mass(double a, double b, double fluid_density) {
  require_section(a, b, fluid_density, "planar_rectangle_added_mass");
  return planar(added_mass::rectangle_section(a, b, fluid_density));
}

}  // namespace samara::models
