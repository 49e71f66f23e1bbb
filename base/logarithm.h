#pragma once

#include <bit>
#include <cstdint>

namespace samara {

/// Natural logarithm of a positive normal number, to one unit in the last place: x = 2^e (1 + f), and the series of
/// log((1 + s)/(1 - s)), s = f/(2 + f) (Sun Microsystems, fdlibm, e_log.c).
[[gnu::always_inline]] inline double log_of(double x) {
  constexpr std::uint64_t kLeast = 0x3fe6a09e667f3bcd;  // sqrt(1/2)
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x) + (0x3ff0000000000000 - kLeast);
  const double e = static_cast<double>(static_cast<std::int32_t>(bits >> 52) - 0x3ff);
  const double f = std::bit_cast<double>((bits & 0x000fffffffffffff) + kLeast) - 1.0;
  const double s = f / (2.0 + f), z = s * s, w = z * z;
  const double even =
      w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
  const double odd =
      z * (6.666666666666735130e-01 +
           w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
  const double half_square = 0.5 * f * f;
  return e * 6.93147180369123816490e-01 -
         ((half_square - (s * (half_square + (even + odd)) + e * 1.90821492927058770002e-10)) - f);
}

}  // namespace samara
