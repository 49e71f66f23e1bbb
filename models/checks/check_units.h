#pragma once

#include <random>

#include "samara/models/checks/check_parts.h"

namespace samara::models {

/// Units that are no SI units: nothing else on units can be checked then.
void check_known_units(const ModelInfo& info, Findings& findings);
/// With the unit of length, mass or time changed, rates, derived defaults, forces and energy follow as their
/// units say.
void check_dimensions(const Model& model, const Point& point, std::mt19937& random, Findings& findings);

}  // namespace samara::models
