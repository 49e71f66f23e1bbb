#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Help with names and texts that a user typed or a file brought.
namespace samara {

/// The candidate with the smallest edit distance to `name`, or an empty string if none is near (more than
/// half of the longer word differs).
std::string nearest_name(std::string_view name, std::span<const std::string> candidates);

/// A half sentence for error messages: `; did you mean "C_D"?` or, where nothing is near,
/// `; known: C_D, m_a, area`.
std::string suggestion(std::string_view name, std::span<const std::string> candidates);

/// Text that may come from anywhere, for a terminal: control characters as \x1b, or \xc2\x9b where they take
/// two bytes. @param kept control characters that are left as they are
std::string printable(std::string_view text, std::string_view kept = "");

/// Whether a name is among others.
bool contains(std::span<const std::string> names, std::string_view name);

/// Names joined by ", ".
std::string join(std::span<const std::string> names);

}  // namespace samara
