#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "report.h"
#include "samara/pgd/sampling/sampling.h"

/// The cases of the benchmark sampling, by subject; each prints its measurements.
namespace samara::benchmarks {

inline constexpr const char* kSampling = "sampling";

/// A function of one output on a box.
struct SampledCase {
  std::string name;
  std::vector<double> lower, upper;
  std::function<double(std::span<const double>)> function;
  double tolerance = 1e-6;
  long max_calls = 10'000;
};

pgd::SamplingResult sample(const SampledCase& sampled, std::uint64_t seed);

/// Errors of a result at random points that the builder did not choose.
struct SampledErrors {
  double relative_rms = 0.0;  ///< root mean square of the error over that of the function
  double over_range = 0.0;    ///< largest error over the range, of the points or seen by the builder
};
SampledErrors errors_of(const SampledCase& sampled, const pgd::SamplingResult& result, int points = 10'000);

/// Borehole, OTL circuit, Black-Scholes.
void run_functions(const Options& options);
/// The largest ratio of their calls to those that took no exploration, the worst of five seeds each.
double calls_over_before();
/// Codebooks of the reference plate and of a vertical fall.
void run_codebooks(const Options& options);
/// Peaks, kinks, jumps, noise: no certificate may state what independent points refute.
void run_guard(const Options& options);

/// Calls of a NumPy program that is kept between batches, beside a loop that does no more than call it.
void run_persistent_command(const Options& options);

/// The flow map of the Lorenz equations, in windows and at once.
void run_lorenz(const Options& options);

}  // namespace samara::benchmarks
