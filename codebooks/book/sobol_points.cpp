#include "samara/codebooks/book/sobol_points.h"

#include <algorithm>

#include <boost/random/sobol.hpp>

#include "samara/pgd/tensors/random.h"

namespace samara::codebooks {

namespace {

std::uint32_t reversed_bits(std::uint32_t x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0F0F0F0Fu) | ((x & 0x0F0F0F0Fu) << 4);
  x = ((x >> 8) & 0x00FF00FFu) | ((x & 0x00FF00FFu) << 8);
  return (x >> 16) | (x << 16);
}

/// Every bit is flipped depending on the seed and the bits above it only: a nested permutation.
std::uint32_t scrambled(std::uint32_t x, std::uint32_t seed) {
  x = reversed_bits(x);
  x += seed;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return reversed_bits(x);
}

}  // namespace

Eigen::MatrixXd sobol_points(int dimensions, int count, std::uint64_t seed) {
  constexpr int kMost = boost::random::default_sobol_table::max_dimension;
  const int sobol = std::min(dimensions, kMost);
  boost::random::sobol engine(static_cast<std::size_t>(sobol));
  pgd::Random random(seed);
  Eigen::Array<std::uint32_t, Eigen::Dynamic, 1> seeds(sobol);
  for (int k = 0; k < sobol; ++k) seeds[k] = static_cast<std::uint32_t>(random.bits() >> 32);
  Eigen::MatrixXd points(dimensions, count);
  for (int j = 0; j < count; ++j) {
    for (int k = 0; k < sobol; ++k) {
      // The engine leaves out the first point, the origin; only with it are 2^m points evenly spread.
      const auto bits = j == 0 ? 0u : static_cast<std::uint32_t>(engine() >> 32);
      points(k, j) = scrambled(bits, seeds[k]) * 0x1.0p-32;
    }
    for (int k = sobol; k < dimensions; ++k) points(k, j) = random.uniform();
  }
  return points;
}

}  // namespace samara::codebooks
