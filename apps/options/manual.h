#pragma once

#include <string>
#include <vector>

#include "options/option_tree.h"

namespace samara::apps {

/// A page for man, of section 1. @param command null: of samara itself, with the list of all
std::string manual_page(const CommandWords* command, const std::vector<CommandWords>& tree);

/// The tree as one JSON object, schema samara-help/1.
std::string tree_json(const std::vector<CommandWords>& tree);

}  // namespace samara::apps
