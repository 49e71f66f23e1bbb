#include <cmath>

#include "cases.h"

// Functions made to deceive: what counts is that no build claims a tolerance that independent points refute.

namespace samara::benchmarks {

namespace {

double sum_of(std::span<const double> x) {
  double sum = 0.0;
  for (const double value : x) sum += value;
  return sum;
}

double two_peaks(std::span<const double> x, double width) {
  double to_first = 0.0, to_second = 0.0;
  for (const double value : x) {
    to_first += (value - 0.3) * (value - 0.3);
    to_second += (value - 0.7) * (value - 0.7);
  }
  return std::exp(-to_first / (width * width)) + std::exp(-to_second / (width * width));
}

std::vector<SampledCase> adversaries(int dimensions) {
  const std::vector<double> zeros(static_cast<std::size_t>(dimensions), 0.0);
  const std::vector<double> ones(static_cast<std::size_t>(dimensions), 1.0);
  const double d = dimensions;
  constexpr long kCalls = 20'000;
  return {
      {"peaks of width 0.1", zeros, ones, [](auto x) { return two_peaks(x, 0.1); }, 1e-3, kCalls},
      {"peaks of width 0.2", zeros, ones, [](auto x) { return two_peaks(x, 0.2); }, 1e-3, kCalls},
      {"kink", zeros, ones, [d](auto x) { return std::abs(sum_of(x) - 0.5 * d); }, 1e-3, kCalls},
      {"pole", zeros, ones, [d](auto x) { return 1.0 / (sum_of(x) - 0.37 * d); }, 1e-3, kCalls},
      {"constant", zeros, ones, [](auto) { return 3.14; }, 1e-6, kCalls},
      {"one coordinate", zeros, ones, [](auto x) { return std::sin(7.0 * x[x.size() / 2]); }, 1e-6, kCalls},
      {"noise", zeros, ones,
       [](auto x) { return std::exp(-sum_of(x)) + 1e-6 * std::sin(1298980.0 * sum_of(x) + 78233.0 * x[0]); },
       1e-7, kCalls},
  };
}

}  // namespace

void run_guard(const Options& options) {
  if (!options.wants("guard")) return;
  int runs = 0, silent_failures = 0, met = 0;
  const std::uint64_t seeds = options.quick ? 1 : 10;
  for (const int dimensions : {4, 6, 8}) {
    for (const SampledCase& sampled : adversaries(dimensions)) {
      for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        const pgd::SamplingResult result = sample(sampled, seed);
        const bool holds = errors_of(sampled, result).over_range <= sampled.tolerance;
        ++runs;
        met += result.tolerance_met() ? 1 : 0;
        silent_failures += result.tolerance_met() && !holds ? 1 : 0;
      }
    }
  }
  print({kSampling, "guard", "silent_failures", static_cast<double>(silent_failures)});
  print({kSampling, "guard", "met", static_cast<double>(met)});
  print({kSampling, "guard", "runs", static_cast<double>(runs)});
}

}  // namespace samara::benchmarks
