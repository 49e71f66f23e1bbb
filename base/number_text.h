#pragma once

#include <string>

namespace samara {

/// A number for a message, in the C locale: the shortest text that reads back as the same double, or rounded
/// to `digits` significant digits where that is asked for.
std::string number_text(double value);
std::string number_text(double value, int digits);

}  // namespace samara
