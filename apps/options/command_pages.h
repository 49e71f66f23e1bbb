#pragma once

#include <array>
#include <string>
#include <string_view>

namespace samara::apps {

/// What the help of a command ends with.
struct CommandPage {
  std::string_view command;
  std::array<std::string_view, 2> examples;
  std::string_view page;  ///< in the sources, and below the folder of the documentation where it is installed
};

/// @returns null for a command without one
const CommandPage* page_of(std::string_view command);

/// "Examples: .. More: docs/queries.md"
std::string footer_of(std::string_view command);

}  // namespace samara::apps
