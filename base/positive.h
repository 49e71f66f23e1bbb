#pragma once

#include <string_view>

namespace samara {

/// @param what the quantity, with its unit  @param where the function it was given to, or empty
/// @throws ArgumentError, naming them and the value, if it is not positive and finite.
void require_positive(double value, std::string_view what, std::string_view where = {});

/// @throws ArgumentError, as above, if the value is negative or not finite.
void require_not_negative(double value, std::string_view what, std::string_view where = {});

}  // namespace samara
