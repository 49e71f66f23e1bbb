#pragma once

#include <memory>
#include <string>
#include <vector>

#include "samara/models/interface/model.h"

namespace samara::models {

/// Names of all models that ship with Samara, sorted.
std::vector<std::string> model_names();

/// @throws ArgumentError if there is no such model; the message names the nearest.
std::shared_ptr<const Model> find_model(const std::string& name);

}  // namespace samara::models
