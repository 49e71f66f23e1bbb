#pragma once

#include <string>
#include <string_view>

/// Products and quotients of unit texts, for labels: "m/s" by "s" gives "m/s^2". Nothing is converted, and
/// symbols need not be known.
namespace samara {

/// Whether the text is a product of symbols with whole exponents, known or not.
bool reads_as_unit(std::string_view text);

/// Equal symbols are put together, "1" if none is left. What does not read as a unit stays as it is, in
/// parentheses.
std::string unit_product(std::string_view a, std::string_view b);
std::string unit_quotient(std::string_view a, std::string_view b);

/// What follows a number: " m/s", and nothing where the unit is "1".
std::string unit_suffix(std::string_view unit);

/// In a column of its own: "m/s", and "-" where the unit is "1".
std::string shown_unit(std::string_view unit);

}  // namespace samara
