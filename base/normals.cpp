#include "samara/base/normals.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "samara/base/logarithm.h"

/// Normal numbers in loops that the compiler makes SIMD code of: no branches, no calls. Each lane
/// does the same operations whatever the machine, so that the bits do not depend on the width, nor
/// on whether one is asked for or many.
namespace samara {

namespace {

/// Two registers of the longest: their chains of operations do not wait for each other.
constexpr int kLanes = 16;

/// Of 32 bits, in 64 where machines multiply those at once: products need no widening on the way then.
using Word =
#ifdef __AVX512DQ__
    std::uint64_t;
#else
    std::uint32_t;
#endif

/// Ten rounds of Philox 4x32 in place.
void mix(Word (&c)[4][kLanes], std::uint32_t key_0, std::uint32_t key_1) {
  constexpr std::uint64_t kLow = 0xffffffff;
  for (int i = 0; i < kLanes; ++i) {
    Word c_0 = c[0][i], c_1 = c[1][i], c_2 = c[2][i], c_3 = c[3][i];
    Word k_0 = key_0, k_1 = key_1;
    for (int round = 0; round < 10; ++round) {
      const std::uint64_t first = std::uint64_t{0xD2511F53} * c_0;
      const std::uint64_t second = std::uint64_t{0xCD9E8D57} * c_2;
      c_0 = static_cast<Word>(second >> 32) ^ c_1 ^ k_0;
      c_2 = static_cast<Word>(first >> 32) ^ c_3 ^ k_1;
      c_1 = static_cast<Word>(second & kLow);
      c_3 = static_cast<Word>(first & kLow);
      k_0 = static_cast<Word>((k_0 + 0x9E3779B9) & kLow);
      k_1 = static_cast<Word>((k_1 + 0xBB67AE85) & kLow);
    }
    c[0][i] = c_0;
    c[1][i] = c_1;
    c[2][i] = c_2;
    c[3][i] = c_3;
  }
}

/// In (0, 1), by steps of 2^-32. (By way of 2^52 + bits, whose own bits need no conversion.)
double open_uniform(Word bits) {
  return (std::bit_cast<double>(bits | 0x4330000000000000) - (0x1.0p52 - 0.5)) * 0x1.0p-32;
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
  // Quarter turns 0 to 4, told apart in doubles: machines select by those.
  const bool is_odd = quarters == 1.0 || quarters == 3.0;
  const double along = is_odd ? sine : cosine, across = is_odd ? cosine : sine;
  const double sign_along = quarters == 1.0 || quarters == 2.0 ? -1.0 : 1.0;
  const double sign_across = quarters == 2.0 || quarters == 3.0 ? -1.0 : 1.0;
  return {sign_along * along, sign_across * across};
}

/// Box and Muller.
void make_normal(const Word* first, const Word* second, double* z, double* other) {
  double cosines[kLanes], sines[kLanes], radii[kLanes];
  for (int i = 0; i < kLanes; ++i) {
    radii[i] = std::sqrt(-2.0 * log_of(open_uniform(first[i])));
    const Direction direction = direction_of(open_uniform(second[i]));
    cosines[i] = direction.cosine;
    sines[i] = direction.sine;
  }
  for (int i = 0; i < kLanes; ++i) {
    z[i] = radii[i] * cosines[i];
    other[i] = radii[i] * sines[i];
  }
}

}  // namespace

void normals_from(std::uint64_t seed, const RandomPlace& first, std::span<std::array<double, 4>> steps) {
  for (std::size_t from = 0; from < steps.size(); from += kLanes) {
    Word words[4][kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const std::uint64_t step = first.step + from + static_cast<std::uint64_t>(i);
      words[0][i] = static_cast<Word>(step & 0xffffffff);
      words[1][i] = static_cast<Word>(step >> 32 | std::uint64_t{first.stream} << 16);
      words[2][i] = static_cast<Word>(first.realisation & 0xffffffff);
      words[3][i] = static_cast<Word>(first.realisation >> 32);
    }
    mix(words, static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32));
    double z[4][kLanes];
    make_normal(words[0], words[1], z[0], z[1]);
    make_normal(words[2], words[3], z[2], z[3]);
    const std::size_t count = std::min(std::size_t{kLanes}, steps.size() - from);
    for (std::size_t i = 0; i < count; ++i) steps[from + i] = {z[0][i], z[1][i], z[2][i], z[3][i]};
  }
}

std::array<double, 4> normals_at(std::uint64_t seed, const RandomPlace& place) {
  std::array<double, 4> z[1];
  normals_from(seed, place, z);
  return z[0];
}

}  // namespace samara
