#pragma once

#include <map>
#include <string>
#include <vector>

namespace samara::apps {

/// A number in SI, or a number with a unit of the dimension of `unit`.
/// @throws ArgumentError naming `what` and the text.
double number_or_quantity(const std::string& what, const std::string& text, const std::string& unit);

/// Values of "NAME=VALUE" texts in SI.
/// @param units of every name that may be set
/// @throws ArgumentError for a text without "=", an unknown name (the nearest is named), one set twice, or a
/// bad value.
std::map<std::string, double> parse_assignments(const std::vector<std::string>& texts,
                                                const std::map<std::string, std::string>& units);

}  // namespace samara::apps
