#include "samara/models/laws/ellipsoid_body.h"

#include "samara/models/law_tools/parameter_list.h"

namespace samara::models::laws {

namespace {

Parameters body_parameters() {
  return {
      positive("a", "m", "semi-axis along body x"),
      positive("b", "m", "semi-axis along body y"),
      positive("c", "m", "semi-axis along body z, the normal of the plate: half of the thickness"),
      positive("density", "kg/m^3", "density of the body; of use for its mass only"),
      with_default(positive("fluid_density", "kg/m^3",
                            "density of the fluid; default: air at 20 degrees C and 1 atm, rounded"),
                   1.2),
      not_negative("g", "m/s^2", 9.81, "gravitational acceleration"),
  };
}

Parameters inertia_parameters() {
  const char* mass = "that of an ellipsoid, 4/3 pi fluid_density a b c A/(2 - A) and so on";
  const char* inertia = "that of an ellipsoid, dissertation (5.11) corrected";
  return {
      derived("mass", "kg", "4/3 pi density a b c", "mass of the body", false),
      derived("displaced_mass", "kg", "4/3 pi fluid_density a b c", "mass of the displaced fluid", true),
      derived("I_x", "kg m^2", "mass (b^2 + c^2)/5",
              "moment of inertia about body x through the centre of mass", false),
      derived("I_y", "kg m^2", "mass (a^2 + c^2)/5",
              "moment of inertia about body y through the centre of mass", false),
      derived("I_z", "kg m^2", "mass (a^2 + b^2)/5",
              "moment of inertia about body z through the centre of mass", false),
      derived("M_x", "kg", mass, "added mass along body x", true),
      derived("M_y", "kg", mass, "added mass along body y", true),
      derived("M_z", "kg", mass, "added mass along body z", true),
      derived("J_x", "kg m^2", inertia, "added moment of inertia about body x", true),
      derived("J_y", "kg m^2", inertia, "added moment of inertia about body y", true),
      derived("J_z", "kg m^2", inertia, "added moment of inertia about body z", true),
      {.name = "r_bx",
       .unit = "m",
       .default_value = 0.0,
       .description = "centre of buoyancy from the centre of mass, body x"},
      {.name = "r_by",
       .unit = "m",
       .default_value = 0.0,
       .description = "centre of buoyancy from the centre of mass, body y"},
      {.name = "r_bz",
       .unit = "m",
       .default_value = 0.0,
       .description = "centre of buoyancy from the centre of mass, body z"},
  };
}

}  // namespace

std::vector<ParameterInfo> EllipsoidBody::parameters() {
  Parameters list = body_parameters();
  append(list, inertia_parameters());
  return list;
}

}  // namespace samara::models::laws
