#pragma once

#include <string>
#include <vector>

namespace samara::apps {

/// Loads shared libraries of models (models/laws/model_library.h), whose names are known from then on.
/// @throws InputError for a file that is no such library, or one for another version; ArgumentError for a model whose
///   name is taken
void load_model_libraries(const std::vector<std::string>& paths);

}  // namespace samara::apps
