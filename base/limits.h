#pragma once

namespace samara {

/// Numbers from plans, captures and calls, in SI units, are at most this large: squares, and products of a
/// few of them, do not overflow.
inline constexpr double kLargestInput = 1e60;

}  // namespace samara
