#pragma once

namespace samara {

/// Numbers from plans, captures and calls, in SI units, are at most this large: squares, and products of a
/// few of them, do not overflow.
inline constexpr double kLargestInput = 1e60;
/// Those of plans, configs and PEtab tables are at least this large, or 0: their reciprocals do not overflow either.
inline constexpr double kSmallestInput = 1e-60;

}  // namespace samara
