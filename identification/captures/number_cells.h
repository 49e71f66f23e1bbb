#pragma once

#include <optional>
#include <string_view>

/// Numbers in cells, labels and rules of sidecars; internal to identification/.
namespace samara::identification {

/// The finite number that a whole text is, if it is one.
std::optional<double> number_in(std::string_view text);

}  // namespace samara::identification
