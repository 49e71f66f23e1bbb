#pragma once

#include <string>
#include <vector>

#include "options/option_tree.h"

namespace samara::apps {

/// What a shell has to be told to complete commands, options, their choices, names of models and, after --set, the
/// names that a model, a codebook or a plan knows (which it asks `samara completion --names` for).
/// @param shell bash, zsh or fish @throws ArgumentError for another
std::string completion_script(const std::string& shell, const std::vector<CommandWords>& tree,
                              const std::vector<std::string>& models);

}  // namespace samara::apps
