#pragma once

#include <string>
#include <string_view>
#include <vector>

/// The grammar of unit texts, whatever their symbols mean; internal to base/.
namespace samara {

/// One symbol of a unit with its whole exponent.
struct UnitFactor {
  std::string symbol;
  int exponent = 1;
};

/// The factors of a unit in the order of the text; those in parentheses carry the exponent of the parentheses,
/// those after a slash the opposite sign. "1" has none.
/// @param what the text to name in errors, quoted
/// @throws ArgumentError if the text is empty, malformed, ambiguous or has exponents beyond any use.
std::vector<UnitFactor> unit_factors(std::string_view text, std::string_view what);

}  // namespace samara
