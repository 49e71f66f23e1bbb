#include "samara/base/streams.h"

#include <cmath>
#include <numbers>

#include <Random123/philox.h>

namespace samara {

namespace {

std::uint32_t low(std::uint64_t bits) {
  return static_cast<std::uint32_t>(bits);
}

std::uint32_t high(std::uint64_t bits) {
  return static_cast<std::uint32_t>(bits >> 32);
}

/// In (0, 1), by steps of 2^-32.
double open_uniform(std::uint32_t bits) {
  return (static_cast<double>(bits) + 0.5) * 0x1.0p-32;
}

}  // namespace

std::array<std::uint32_t, 4> philox_block(const std::array<std::uint32_t, 4>& counter,
                                          const std::array<std::uint32_t, 2>& key) {
  const r123::Philox4x32::ctr_type random =
      r123::Philox4x32()({{counter[0], counter[1], counter[2], counter[3]}}, {{key[0], key[1]}});
  return {random[0], random[1], random[2], random[3]};
}

std::array<double, 4> normals_at(std::uint64_t seed, const RandomPlace& place) {
  const std::uint32_t step_and_stream = high(place.step) | std::uint32_t{place.stream} << 16;
  const std::array<std::uint32_t, 4> random =
      philox_block({low(place.step), step_and_stream, low(place.realisation), high(place.realisation)},
                   {low(seed), high(seed)});
  std::array<double, 4> normals;
  for (std::size_t pair = 0; pair < 4; pair += 2) {  // Box and Muller
    const double radius = std::sqrt(-2.0 * std::log(open_uniform(random[pair])));
    const double angle = 2.0 * std::numbers::pi * open_uniform(random[pair + 1]);
    normals[pair] = radius * std::cos(angle);
    normals[pair + 1] = radius * std::sin(angle);
  }
  return normals;
}

std::uint64_t Stream::bits() {
  const std::uint64_t place = counter_++;
  if (place % 2 == 1) return block_[1];
  const std::uint64_t block = place / 2;
  const std::array<std::uint32_t, 4> random =
      philox_block({low(block), high(block), low(number_), high(number_)}, {low(seed_), high(seed_)});
  block_ = {std::uint64_t{random[1]} << 32 | random[0], std::uint64_t{random[3]} << 32 | random[2]};
  return block_[0];
}

double Stream::normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

}  // namespace samara
