#include "samara/models/unit_warnings.h"

#include <fmt/format.h>

namespace samara::models {

namespace {

// Between these values nothing is said.
constexpr double kAnySolid = 100.0, kAnyFluid = 1000.0;
constexpr double kLongest = 10.0;

}  // namespace

std::vector<std::string> density_warnings(double solid, double fluid) {
  std::vector<std::string> warnings;
  if (solid > 0.0 && solid < 20.0) {
    warnings.push_back(
        fmt::format("the solid has a density of {:g} kg/m^3: this looks like g/cm^3; {:g} kg/m^3?", solid,
                    1000.0 * solid));
  }
  if (fluid > 5.0 && fluid < 500.0) {
    warnings.push_back(
        fmt::format("the fluid has a density of {:g} kg/m^3, between those of gases and liquids", fluid));
  } else if ((fluid > 0.0 && fluid < 0.05) || fluid > 2e4) {
    warnings.push_back(fmt::format("the fluid has a density of {:g} kg/m^3; air has 1.2, water 998", fluid));
  }
  return warnings;
}

std::vector<std::string> unit_warnings(const Model& model, const std::map<std::string, double>& values) {
  double solid = kAnySolid, fluid = kAnyFluid;
  std::vector<std::string> warnings;
  for (const ParameterInfo& parameter : model.info().parameters) {
    const auto given = values.find(parameter.name);
    if (given == values.end()) continue;
    if (parameter.name == "density" && parameter.unit == "kg/m^3") solid = given->second;
    if (parameter.name == "fluid_density" && parameter.unit == "kg/m^3") fluid = given->second;
    if (parameter.unit == "m" && given->second > kLongest) {
      warnings.push_back(
          fmt::format("{} is {:g} m: was it given in mm or cm?", parameter.name, given->second));
    }
  }
  const std::vector<std::string> of_densities = density_warnings(solid, fluid);
  warnings.insert(warnings.end(), of_densities.begin(), of_densities.end());
  return warnings;
}

}  // namespace samara::models
