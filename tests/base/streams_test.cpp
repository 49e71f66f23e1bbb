#include "samara/base/streams.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <catch2/catch.hpp>

#include "samara/base/normals.h"

using samara::Stream;

TEST_CASE("a stream gives the published numbers of its generator") {
  // Known answers of Philox 4x32-10 in Random123, for a counter and a key of zeros.
  Stream stream(0, 0);
  CHECK(stream.bits() == 0xe169c58d6627e8d5);
  CHECK(stream.bits() == 0x9b00dbd8bc57ac4c);
}

TEST_CASE("streams of one seed, of neighbouring seeds, and their numbers are independent of each other") {
  // Correlations of n pairs scatter by 1/sqrt(n): five times that happens once in two million.
  constexpr int kNumbers = 40000;
  const double allowed = 5.0 / std::sqrt(kNumbers);
  Stream a(7, 1), b(7, 2), c(8, 1);
  double sum = 0.0, squares = 0.0, ab = 0.0, ac = 0.0, next = 0.0, last = 0.0;
  for (int k = 0; k < kNumbers; ++k) {
    const double x = a.normal(), y = b.normal(), z = c.normal();
    sum += x;
    squares += x * x;
    ab += x * y;
    ac += x * z;
    next += x * last;
    last = x;
  }
  CHECK(std::abs(sum / kNumbers) < allowed);
  CHECK(std::abs(squares / kNumbers - 1.0) < std::sqrt(2.0) * allowed);
  CHECK(std::abs(ab / kNumbers) < allowed);
  CHECK(std::abs(ac / kNumbers) < allowed);
  CHECK(std::abs(next / kNumbers) < allowed);
}

TEST_CASE("uniform numbers of a stream fill the interval from 0 to 1, without 1") {
  Stream stream(3, 5);
  double least = 1.0, most = 0.0;
  for (int k = 0; k < 10000; ++k) {
    const double u = stream.uniform();
    least = std::min(least, u);
    most = std::max(most, u);
  }
  CHECK(least >= 0.0);
  CHECK(least < 1e-3);
  CHECK(most < 1.0);
  CHECK(most > 0.999);
}

TEST_CASE("blocks of random numbers have the published known answers of Philox 4x32-10") {
  using Block = std::array<std::uint32_t, 4>;
  constexpr std::uint32_t ones = 0xffffffff;
  CHECK(samara::philox_block({0, 0, 0, 0}, {0, 0}) == Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  CHECK(samara::philox_block({ones, ones, ones, ones}, {ones, ones}) ==
        Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  CHECK(samara::philox_block({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
        Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("normal numbers are those of Box and Muller, whether one is asked for or many") {
  std::array<std::array<double, 4>, 1000> many;
  samara::normals_from(77, {.realisation = 5, .step = 40, .stream = 3}, many);
  for (std::size_t k = 0; k < many.size(); ++k) {
    const std::uint64_t step = 40 + k;
    CHECK(many[k] == samara::normals_at(77, {.realisation = 5, .step = step, .stream = 3}));
    const auto bits = samara::philox_block({static_cast<std::uint32_t>(step), 3u << 16, 5, 0}, {77, 0});
    for (std::size_t pair = 0; pair < 4; pair += 2) {
      const double radius = std::sqrt(-2.0 * std::log((bits[pair] + 0.5) * 0x1p-32));
      const double angle = 2.0 * std::acos(-1.0) * (bits[pair + 1] + 0.5) * 0x1p-32;
      CHECK(std::abs(many[k][pair] - radius * std::cos(angle)) < 1e-14);
      CHECK(std::abs(many[k][pair + 1] - radius * std::sin(angle)) < 1e-14);
    }
  }
}

TEST_CASE("normal numbers are independent between realisations, components, steps and streams") {
  constexpr int kNumbers = 40000;
  const double allowed = 4.0 / std::sqrt(kNumbers);
  std::array<double, 6> sums = {};
  double squares = 0.0, fourth = 0.0;
  for (std::uint64_t n = 0; n < kNumbers; ++n) {
    const auto here = samara::normals_at(5, {.realisation = n, .step = 3, .stream = 1});
    const auto next = samara::normals_at(5, {.realisation = n + 1, .step = 3, .stream = 1});
    const auto later = samara::normals_at(5, {.realisation = n, .step = 4, .stream = 1});
    const auto other = samara::normals_at(5, {.realisation = n, .step = 3, .stream = 2});
    sums[0] += here[0] * next[0];
    sums[1] += here[0] * here[1];
    sums[2] += here[1] * here[2];
    sums[3] += here[0] * later[0];
    sums[4] += here[0] * other[0];
    sums[5] += here[0];
    squares += here[0] * here[0];
    fourth += std::pow(here[2], 4);
  }
  for (const double sum : sums) CHECK(std::abs(sum / kNumbers) < allowed);
  CHECK(std::abs(squares / kNumbers - 1.0) < std::sqrt(2.0) * allowed);
  CHECK(std::abs(fourth / kNumbers - 3.0) < std::sqrt(96.0) * allowed);
}
