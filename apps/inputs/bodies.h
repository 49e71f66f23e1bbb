#pragma once

#include <map>
#include <string>

#include "options/arguments.h"
#include "samara/models/added_mass/body_in_fluid.h"

namespace samara::apps {

/// @throws ArgumentError for a number or a unit that cannot be read, and where a density is missing
models::BodyDescription description_of(const BodyWords& words);

/// body_in_fluid(), with progress, warnings and how panels were solved on stderr.
models::BodyInFluid work_out(const models::BodyDescription& description);

/// Of the model `kirchhoff_body`, for plans with a body.
std::map<std::string, double> parameters_of(const models::BodyDescription& description);

}  // namespace samara::apps
