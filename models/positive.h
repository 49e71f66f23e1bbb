#pragma once

#include <string_view>

namespace samara::models {

/// @throws ArgumentError, naming the quantity, its value and `where`, if it is not a positive number.
void require_positive(double value, std::string_view what, std::string_view where);

}  // namespace samara::models
