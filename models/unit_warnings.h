#pragma once

#include <map>
#include <string>
#include <vector>

#include "samara/models/model.h"

/// What looks like a mistake of units: a value that is legal, but that no body or fluid has.
namespace samara::models {

/// Densities [kg/m^3] of a solid and of the fluid around it: solids below 20, fluids between 5 and 500 or
/// below 0.05 or above 2e4. One sentence each. Values that are not positive are errors elsewhere.
std::vector<std::string> density_warnings(double solid, double fluid);

/// The same for values given to a model's parameters, by their names and units: `density` and `fluid_density`
/// [kg/m^3], and lengths [m] above 10.
/// @param values SI, by name; names that are no parameters are left alone
std::vector<std::string> unit_warnings(const Model& model, const std::map<std::string, double>& values);

}  // namespace samara::models
