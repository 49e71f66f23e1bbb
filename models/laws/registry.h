#pragma once

#include <memory>
#include <string>
#include <vector>

#include "samara/models/interface/model.h"

namespace samara::models {

/// Names of all models that ship with Samara or were added, sorted.
std::vector<std::string> model_names();

/// @throws ArgumentError if there is no such model; the message names the nearest.
std::shared_ptr<const Model> find_model(const std::string& name);

/// The same where there may be none: null.
std::shared_ptr<const Model> find_model_or_null(const std::string& name);

/// Makes a model known by its name, in this process and from now on. May be called by several threads.
/// @throws ArgumentError for a null pointer, and if there is another model, or a field, of this name
void add_model(const std::shared_ptr<const Model>& model);

}  // namespace samara::models
