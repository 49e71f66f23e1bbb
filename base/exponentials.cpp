#include "samara/base/exponentials.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "samara/base/logarithm.h"

namespace samara {

namespace {

constexpr std::size_t kAtOnce = 8;

/// exp(r), |r| <= ln(2)/2: Taylor's series, even and odd powers apart, as two chains of products that do not wait for
/// each other. What is left out is 4e-18.
double exponential_near_zero(double r) {
  constexpr double kOver[] = {1.0 / 2.0,       1.0 / 6.0,        1.0 / 24.0,        1.0 / 120.0,
                              1.0 / 720.0,     1.0 / 5040.0,     1.0 / 40320.0,     1.0 / 362880.0,
                              1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0};
  const double s = r * r;
  const double even =
      kOver[0] + s * (kOver[2] + s * (kOver[4] + s * (kOver[6] + s * (kOver[8] + s * kOver[10]))));
  const double odd =
      kOver[1] + s * (kOver[3] + s * (kOver[5] + s * (kOver[7] + s * (kOver[9] + s * kOver[11]))));
  return 1.0 + (r + s * (even + r * odd));
}

/// x = n ln(2) + r.
double exponential(double x) {
  constexpr double kLeast = -707.7, kMost = 709.782712893384;
  // Of 32 bits, so that its product with n is exact, and the rest (fdlibm, e_exp.c).
  constexpr double kLn2High = 6.93147180369123816490e-01, kLn2Low = 1.90821492927058770002e-10;
  constexpr double kPerLn2 = 1.44269504088896338700;
  constexpr double kShift = 0x1.8p52;  // a sum with it has no bits left for less than a whole
  const double shifted = x * kPerLn2 + kShift;
  const double n = shifted - kShift;
  const double r = (x - n * kLn2High) - n * kLn2Low;
  // 2^(n - 1) by its exponent; n is in the lowest bits of the sum.
  const double half_scale = std::bit_cast<double>((std::bit_cast<std::uint64_t>(shifted) + 1022) << 52);
  const double value = 2.0 * exponential_near_zero(r) * half_scale;
  const double from_below = x < kLeast ? 0.0 : value;
  return x > kMost ? std::numeric_limits<double>::infinity() : from_below;
}

/// one(x) in place of each x; those that fill no eight are computed among others, so that all take one way.
template <class One>
void take_all(std::span<double> x, const One& one) {
  double* const from = x.data();
  const std::size_t whole = x.size() / kAtOnce * kAtOnce;
  for (std::size_t first = 0; first < whole; first += kAtOnce) {
    for (std::size_t i = 0; i < kAtOnce; ++i) from[first + i] = one(from[first + i]);
  }
  if (whole == x.size()) return;
  double last[kAtOnce];
  std::fill_n(last, kAtOnce, 1.0);
  std::copy(from + whole, from + x.size(), last);
  for (double& value : last) value = one(value);
  std::copy_n(last, x.size() - whole, from + whole);
}

}  // namespace

void take_exponentials(std::span<double> x) {
  take_all(x, [](double value) { return exponential(value); });
}

void take_logarithms(std::span<double> x) {
  take_all(x, [](double value) { return log_of(value); });
}

}  // namespace samara
