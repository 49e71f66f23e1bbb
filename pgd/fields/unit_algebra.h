#pragma once

#include <string>
#include <string_view>

/// Products and quotients of unit texts, for labels: "m/s" by "s" gives "m/s^2". Nothing is converted.
namespace samara::pgd {

/// Units are products of symbols with whole exponents ("kg m^2", "m s^-1", "kg/m^3"); equal symbols are put
/// together, "1" if none is left. A text of another form, with parentheses for instance, stays as it is, in
/// parentheses.
std::string unit_product(std::string_view a, std::string_view b);
std::string unit_quotient(std::string_view a, std::string_view b);

}  // namespace samara::pgd
