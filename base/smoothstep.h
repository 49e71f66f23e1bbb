#pragma once

#include <algorithm>

/// How numbers go from one value to another without a jump of their rate.
namespace samara {

/// 3 s^2 - 2 s^3 within [0, 1], 0 before and 1 after it.
inline double smoothstep(double s) {
  const double inside = std::clamp(s, 0.0, 1.0);
  return inside * inside * (3.0 - 2.0 * inside);
}

/// The number that has gone a share, 0 to 1, of the way between two; at the end of it `to` itself, to the last bit.
inline double gone(double from, double to, double share) {
  return share == 1.0 ? to : from + share * (to - from);
}

}  // namespace samara
