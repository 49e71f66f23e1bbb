#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace samara::pgd {

/// Small seeded generator (splitmix64, Steele, Lea and Flood 2014): the same numbers on every platform, which
/// the distributions of the standard library do not promise.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// What a generator has to be made from to go on as this one does.
  std::uint64_t state() const { return state_; }

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  /// In [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  /// In 0 .. n - 1.
  int below(int n) { return static_cast<int>(uniform() * n); }
  /// Standard normal (Box and Muller).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  std::uint64_t state_;
};

}  // namespace samara::pgd
