#pragma once

#include <map>
#include <string>
#include <vector>

#include "samara/models/interface/model.h"

/// Warnings of values that are allowed, but that no real body or fluid has.
namespace samara::models {

/// Densities [kg/m^3] of a solid and of the fluid around it: solids below 20, fluids between 5 and 500 or
/// below 0.05 or above 2e4. One sentence each. Values that are not positive are errors elsewhere.
std::vector<std::string> density_warnings(double solid, double fluid);

/// The same for values given to a model's parameters, by their names and units, and beside it
/// - lengths [m] above 10;
/// - moments of inertia of which one exceeds the sum of the other two, which no body has, or that is larger
///   than if all mass lay at the rim;
/// - plates that are thicker than they are wide.
/// One sentence each. Where not all parameters that the model asks for are among the values, what follows
/// from them is not checked; values outside their meaning are errors elsewhere.
/// @param values SI, by name; other names are ignored
std::vector<std::string> parameter_warnings(const Model& model, const std::map<std::string, double>& values);

}  // namespace samara::models
