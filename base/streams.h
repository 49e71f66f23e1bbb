#pragma once

#include <array>
#include <cstdint>

namespace samara {

/// Random numbers by counter: stream `number` of a seed gives the same numbers alone, beside others in any order, and
/// on any thread. Philox 4x32 with ten rounds: J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, Parallel random
/// numbers: as easy as 1, 2, 3, SC'11 (2011).
class Stream {
 public:
  Stream(std::uint64_t seed, std::uint64_t number) : seed_(seed), number_(number) {}

  std::uint64_t bits();
  /// In [0, 1), by steps of 2^-53.
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  /// Standard normal (Box and Muller).
  double normal();

 private:
  std::uint64_t seed_, number_;
  std::uint64_t counter_ = 0;
  std::array<std::uint64_t, 2> block_ = {};
};

/// One block of Philox 4x32-10.
std::array<std::uint32_t, 4> philox_block(const std::array<std::uint32_t, 4>& counter,
                                          const std::array<std::uint32_t, 2>& key);

}  // namespace samara
