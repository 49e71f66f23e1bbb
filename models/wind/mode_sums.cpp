#include "samara/models/wind/mode_sums.h"

#include <experimental/simd>

namespace samara::models::wind {

namespace {

namespace stdx = std::experimental;
using ModePack = stdx::native_simd<double>;

static_assert(kModeLanes % ModePack::size() == 0);

ModePack load_modes(const double* from) {
  return ModePack(from, stdx::element_aligned);
}

/// The nearest whole number, of size below 2^51: the sum has no bits left for less.
ModePack nearest_whole(ModePack x) {
  constexpr double kShift = 0x1.8p52;
  const ModePack shifted = x + kShift;
  return shifted - kShift;
}

/// Even and odd powers apart: two chains of products that need not wait for each other.
template <std::size_t N>
ModePack polynomial(const double (&coefficients)[N], ModePack x) {
  constexpr std::size_t kEven = (N - 1) / 2 * 2, kOdd = (N - 2) / 2 * 2 + 1;
  const ModePack x2 = x * x;
  ModePack even = coefficients[kEven], odd = coefficients[kOdd];
  for (std::size_t i = kEven; i >= 2; i -= 2) even = even * x2 + coefficients[i - 2];
  for (std::size_t i = kOdd; i >= 3; i -= 2) odd = odd * x2 + coefficients[i - 2];
  return odd * x + even;
}

struct SineCosine {
  ModePack sine, cosine;
};

/// Taylor's series about the nearest multiple of pi, n pi: they change sign together with n. Within 4e-16 of their size
/// there for |x| up to 1e5, beyond that by as much as pi in three parts has lost, 1e-21 |x|.
SineCosine sine_cosine(ModePack x) {
  constexpr double kSine[] = {1.0,
                              -1.0 / 6.0,
                              1.0 / 120.0,
                              -1.0 / 5040.0,
                              1.0 / 362880.0,
                              -1.0 / 39916800.0,
                              1.0 / 6227020800.0,
                              -1.0 / 1307674368000.0,
                              1.0 / 355687428096000.0,
                              -1.0 / 121645100408832000.0};
  constexpr double kCosine[] = {1.0,
                                -1.0 / 2.0,
                                1.0 / 24.0,
                                -1.0 / 720.0,
                                1.0 / 40320.0,
                                -1.0 / 3628800.0,
                                1.0 / 479001600.0,
                                -1.0 / 87178291200.0,
                                1.0 / 20922789888000.0,
                                -1.0 / 6402373705728000.0,
                                1.0 / 2432902008176640000.0};
  // The first two have 33 bits, so that their products with n up to 2^20 are exact.
  constexpr double kPi1 = 0x1.921fb544p+1, kPi2 = 0x1.0b4611a6p-33, kPi3 = 0x1.3198a2e037073p-68;
  constexpr double kPerPi = 0.31830988618379067;
  const ModePack n = nearest_whole(x * kPerPi);
  const ModePack r = ((x - n * kPi1) - n * kPi2) - n * kPi3;
  const ModePack off = 0.5 * n - nearest_whole(0.5 * n);  // 0 where n is even, else 1/2 or -1/2
  const ModePack sign = 1.0 - 8.0 * off * off;
  const ModePack r2 = r * r;
  return {sign * r * polynomial(kSine, r2), sign * polynomial(kCosine, r2)};
}

/// 2 J1(q)/q within 1e-7. M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions (1964), 9.4.4 and 9.4.6.
ModePack ellipse_filter(ModePack q2) {
  constexpr double kNear[] = {1.0, -1.1249997, 0.42187146, -0.07908578, 0.00886638, -0.00063522, 0.00002218};
  constexpr double kSize[] = {0.79788456,  0.00000156, 0.01659667, 0.00017105,
                              -0.00249511, 0.00113653, -0.00020033};
  constexpr double kPhase[] = {-2.35619449, 0.12499612, 0.00005650, -0.00637879,
                               0.00074348,  0.00079824, -0.00029166};
  const ModePack near = polynomial(kNear, stdx::min(q2, ModePack(9.0)) / 9.0);
  if (stdx::none_of(q2 > 9.0)) return near;
  const ModePack q = stdx::sqrt(stdx::max(q2, ModePack(9.0)));
  const ModePack share = 3.0 / q;
  ModePack far = 2.0 * polynomial(kSize, share) / (q * stdx::sqrt(q)) *
                 sine_cosine(q + polynomial(kPhase, share)).cosine;
  stdx::where(q2 <= 9.0, far) = near;
  return far;
}

ModePack product(ModePack x, ModePack y, ModePack z, const double* v) {
  return x * v[0] + y * v[1] + z * v[2];
}

template <bool over_ellipse>
void sum_all(const ModeRows& modes, const double* place, double t, const double* first, const double* second,
             ModeSum& sum) {
  ModePack velocity[3] = {}, gradient[9] = {}, rate[3] = {};
  for (std::size_t m = 0; m < modes.count; m += ModePack::size()) {
    const auto row = [&](std::size_t i) { return load_modes(modes.numbers + i * modes.count + m); };
    const ModePack k[3] = {row(0), row(1), row(2)};
    const ModePack frequency = row(3);
    SineCosine wave = sine_cosine(product(k[0], k[1], k[2], place) + frequency * t);
    if constexpr (over_ellipse) {
      const ModePack q1 = product(k[0], k[1], k[2], first);
      const ModePack q2 = product(k[0], k[1], k[2], second);
      const ModePack filter = ellipse_filter(q1 * q1 + q2 * q2);
      wave = {filter * wave.sine, filter * wave.cosine};
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const ModePack a = row(4 + i), b = row(7 + i);
      velocity[i] += a * wave.cosine + b * wave.sine;
      const ModePack slope = b * wave.cosine - a * wave.sine;
      for (std::size_t j = 0; j < 3; ++j) gradient[3 * j + i] += slope * k[j];
      rate[i] += slope * frequency;
    }
  }
  for (std::size_t i = 0; i < 3; ++i) sum.velocity[i] = stdx::reduce(velocity[i]);
  for (std::size_t i = 0; i < 9; ++i) sum.gradient[i] = stdx::reduce(gradient[i]);
  for (std::size_t i = 0; i < 3; ++i) sum.rate[i] = stdx::reduce(rate[i]);
}

}  // namespace

void sum_modes(const ModeRows& modes, const double* place, double t, ModeSum& sum) {
  sum_all<false>(modes, place, t, nullptr, nullptr, sum);
}

void sum_modes_over_ellipse(const ModeRows& modes, const double* place, double t, const double* first,
                            const double* second, ModeSum& sum) {
  sum_all<true>(modes, place, t, first, second, sum);
}

}  // namespace samara::models::wind
