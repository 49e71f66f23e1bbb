#include "samara/models/added_mass/planar.h"

#include "samara/base/require.h"
#include "samara/models/added_mass/planar_sections.h"

namespace samara::models {

namespace {

void require_section(double chord, double thickness, double fluid_density, const char* where) {
  require_positive(chord, "chord a [m]", where);
  require_positive(fluid_density, "fluid density [kg/m^3]", where);
  require_not_negative(thickness, "thickness b [m]", where);
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
