#pragma once

#include <span>
#include <string>

namespace samara::identification {

/// Doubles, little-endian, as base64 (RFC 4648): how pages carry many numbers.
std::string base64(std::span<const double> values);

}  // namespace samara::identification
