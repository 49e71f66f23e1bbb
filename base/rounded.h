#pragma once

#include <optional>
#include <string>

namespace samara {

/// A value as far as its error leaves it: to the decimal of the error's second digit, "1.169" for 1.16917
/// with 0.0954, "1200" for 1234.5 with 130, and to six digits at most. Without an error (none, zero, not
/// finite) to `digits` significant digits.
std::string rounded(double value, std::optional<double> error, int digits = 4);

/// "1.169 +- 0.095", and the rounded value alone where there is no error.
std::string with_error(double value, std::optional<double> error, int digits = 4);

}  // namespace samara
