#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace samara::benchmarks {

/// A function on the unit cube made to deceive: a smooth ground with a range of one, and mostly one feature
/// that acts in a small part of the box only, turned at random. Drawn from a seed.
///
/// The families were fixed before the builder was tuned on them; change them only together with all figures
/// that rest on them.
struct GuardedFunction {
  std::string family;
  int dimensions = 0;
  std::function<double(std::span<const double>)> value;
  bool has_feature = false;
  /// Of the box, where the feature alone exceeds the tolerance: log-uniform in 1e-4 .. 1e-1 (of noise, where
  /// its amplitude does).
  double share = 0.0;
  /// Points at which the feature is at its largest.
  std::vector<std::vector<double>> places;
};

/// peak, ridge, sheet, kink, jump, pole, interaction, noise: one feature each. smooth: none.
const std::vector<std::string>& guard_families();

/// @param tolerance over the range, from which on a value is wrong
GuardedFunction guarded_function(const std::string& family, std::uint64_t seed, double tolerance);

/// Six inputs, a plane plus exp(-1/2 |W (x - c)|^2) of the plane's range, W turned at random with widths of
/// 0.08 to 0.15.
GuardedFunction oblique_peak(std::uint64_t seed);

}  // namespace samara::benchmarks
