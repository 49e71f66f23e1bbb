#include "samara/models/bodies/scaling_numbers.h"

#include <cmath>
#include <numbers>

#include "samara/base/require.h"

namespace samara::models {

namespace {

using std::numbers::pi;

void require_densities(double solid_density, double fluid_density, const char* where) {
  require_positive(solid_density, "density of the solid [kg/m^3]", where);
  require_positive(fluid_density, "density of the fluid [kg/m^3]", where);
}

}  // namespace

double fall_speed_scale(double solid_density, double fluid_density, double thickness, double gravity) {
  require_densities(solid_density, fluid_density, "fall_speed_scale");
  require_positive(thickness, "thickness [m]", "fall_speed_scale");
  require_positive(gravity, "gravity [m/s^2]", "fall_speed_scale");
  return std::sqrt(std::abs(solid_density - fluid_density) / fluid_density * gravity * thickness);
}

double fall_reynolds_number(double solid_density, double fluid_density, double length, double thickness,
                            double kinematic_viscosity, double gravity) {
  require_positive(length, "length [m]", "fall_reynolds_number");
  require_positive(kinematic_viscosity, "kinematic viscosity [m^2/s]", "fall_reynolds_number");
  return fall_speed_scale(solid_density, fluid_density, thickness, gravity) * length / kinematic_viscosity;
}

double inertia_ratio_of_disc(double solid_density, double fluid_density, double diameter, double thickness) {
  require_densities(solid_density, fluid_density, "inertia_ratio_of_disc");
  require_positive(diameter, "diameter [m]", "inertia_ratio_of_disc");
  require_positive(thickness, "thickness [m]", "inertia_ratio_of_disc");
  return pi * solid_density * thickness / (64.0 * fluid_density * diameter);
}

double inertia_ratio_of_plate(double solid_density, double fluid_density, double chord, double thickness) {
  require_densities(solid_density, fluid_density, "inertia_ratio_of_plate");
  require_positive(chord, "chord [m]", "inertia_ratio_of_plate");
  require_positive(thickness, "thickness [m]", "inertia_ratio_of_plate");
  return 8.0 * solid_density * thickness * (chord * chord + thickness * thickness) /
         (3.0 * pi * fluid_density * chord * chord * chord);
}

double inertia_ratio_of_ellipse(double solid_density, double fluid_density, double a, double b) {
  require_densities(solid_density, fluid_density, "inertia_ratio_of_ellipse");
  require_positive(a, "semi-axis a [m]", "inertia_ratio_of_ellipse");
  require_positive(b, "semi-axis b [m]", "inertia_ratio_of_ellipse");
  return solid_density * b / (fluid_density * a);
}

}  // namespace samara::models
