#include "samara/base/normals.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

/// Normal numbers in loops that the compiler makes SIMD code of: no branches, no calls. Each lane does the same
/// operations whatever the machine, so that the bits do not depend on the width, nor on whether one is asked for or many.
namespace samara {

namespace {

constexpr std::size_t kLanes = 8;
using Words = std::array<std::uint32_t, kLanes>;
using Numbers = std::array<double, kLanes>;

/// Ten rounds of Philox 4x32 in place.
void mix(std::array<Words, 4>& c, std::uint32_t key_0, std::uint32_t key_1) {
  for (int round = 0; round < 10; ++round) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const std::uint64_t first = std::uint64_t{0xD2511F53} * c[0][i];
      const std::uint64_t second = std::uint64_t{0xCD9E8D57} * c[2][i];
      c[0][i] = static_cast<std::uint32_t>(second >> 32) ^ c[1][i] ^ key_0;
      c[2][i] = static_cast<std::uint32_t>(first >> 32) ^ c[3][i] ^ key_1;
      c[1][i] = static_cast<std::uint32_t>(second);
      c[3][i] = static_cast<std::uint32_t>(first);
    }
    key_0 += 0x9E3779B9;
    key_1 += 0xBB67AE85;
  }
}

/// In (0, 1), by steps of 2^-32. (By way of a signed number, which machines convert at once.)
double open_uniform(std::uint32_t bits) {
  return (static_cast<double>(static_cast<std::int32_t>(bits ^ 0x80000000)) + 2147483648.5) * 0x1.0p-32;
}

/// Natural logarithm of a positive normal number, to one unit in the last place: x = 2^e (1 + f), and the series of
/// log((1 + s)/(1 - s)), s = f/(2 + f) (Sun Microsystems, fdlibm, e_log.c).
double log_of(double x) {
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

struct Direction {
  double cosine, sine;
};

/// Of the angle 2 pi u, u in (0, 1): the nearest quarter turn, and the series for the rest of at most pi/4 (fdlibm,
/// k_sin.c, k_cos.c).
Direction direction_of(double u) {
  const double quarters = std::floor(4.0 * u + 0.5);
  const double angle = (u - 0.25 * quarters) * (2.0 * std::numbers::pi);
  const double z = angle * angle;
  const double sine =
      angle + angle * z *
                  (-1.66666666666666324348e-01 +
                   z * (8.33333333332248946124e-03 +
                        z * (-1.98412698298579493134e-04 +
                             z * (2.75573137070700676789e-06 +
                                  z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
  const double cosine =
      1.0 - 0.5 * z +
      z * z *
          (4.16666666666666019037e-02 +
           z * (-1.38888888888741095749e-03 +
                z * (2.48015872894767294178e-05 +
                     z * (-2.75573143513906633035e-07 +
                          z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
  const auto turn = static_cast<std::int32_t>(quarters);
  const double along = (turn & 1) != 0 ? sine : cosine, across = (turn & 1) != 0 ? cosine : sine;
  return {((turn + 1) & 2) != 0 ? -along : along, (turn & 2) != 0 ? -across : across};
}

/// Box and Muller.
void make_normal(const Words& first, const Words& second, Numbers& z, Numbers& other) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    const double radius = std::sqrt(-2.0 * log_of(open_uniform(first[i])));
    const Direction direction = direction_of(open_uniform(second[i]));
    z[i] = radius * direction.cosine;
    other[i] = radius * direction.sine;
  }
}

}  // namespace

void normals_from(std::uint64_t seed, const RandomPlace& first, std::span<std::array<double, 4>> steps) {
  for (std::size_t from = 0; from < steps.size(); from += kLanes) {
    std::array<Words, 4> words;
    for (std::size_t i = 0; i < kLanes; ++i) {
      const std::uint64_t step = first.step + from + i;
      words[0][i] = static_cast<std::uint32_t>(step);
      words[1][i] = static_cast<std::uint32_t>(step >> 32) | std::uint32_t{first.stream} << 16;
      words[2][i] = static_cast<std::uint32_t>(first.realisation);
      words[3][i] = static_cast<std::uint32_t>(first.realisation >> 32);
    }
    mix(words, static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32));
    std::array<Numbers, 4> z;
    make_normal(words[0], words[1], z[0], z[1]);
    make_normal(words[2], words[3], z[2], z[3]);
    for (std::size_t i = 0; i < std::min(kLanes, steps.size() - from); ++i)
      steps[from + i] = {z[0][i], z[1][i], z[2][i], z[3][i]};
  }
}

std::array<double, 4> normals_at(std::uint64_t seed, const RandomPlace& place) {
  std::array<double, 4> z[1];
  normals_from(seed, place, z);
  return z[0];
}

}  // namespace samara
