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

}  // namespace

std::array<std::uint32_t, 4> philox_block(const std::array<std::uint32_t, 4>& counter,
                                          const std::array<std::uint32_t, 2>& key) {
  const r123::Philox4x32::ctr_type random =
      r123::Philox4x32()({{counter[0], counter[1], counter[2], counter[3]}}, {{key[0], key[1]}});
  return {random[0], random[1], random[2], random[3]};
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
