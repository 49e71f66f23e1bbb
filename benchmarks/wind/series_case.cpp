#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "cases.h"
#include "samara/models/wind/wind_series.h"

namespace samara::benchmarks {

namespace {

using namespace models::wind;

constexpr double kDuration = 600.0, kStep = 0.05, kAlongDeviation = 1.7;

/// The transform of a series at a multiple of 1/600 Hz, by the sum.
std::complex<double> transform_at(const Eigen::VectorXd& x, int line) {
  const auto samples = static_cast<long>(x.size());
  std::complex<double> sum = 0.0;
  for (long j = 0; j < samples; ++j) {
    const double turns = static_cast<double>(line * j % samples) / static_cast<double>(samples);
    sum += x[j] * std::polar(1.0, -2.0 * std::numbers::pi * turns);
  }
  return kStep * sum;
}

}  // namespace

void series_case(const Options& options) {
  const int seeds = options.quick ? 100 : 1000;
  constexpr int kBands = 12, kLinesOfBand = 12;
  const WindProfile profile({.speed = 10.0, .height = 30.0});
  SeriesOptions series_options{.sigma = kAlongDeviation, .step = kStep, .samples = 12000};
  series_options.points.resize(3, 3);
  series_options.points << 0.0, 0.0, 0.0, 0.0, 5.0, 15.0, 30.0, 30.0, 30.0;
  // Bands from 1/600 to 10 Hz, the lines of each spread over it.
  const double first = std::log(1.0 / kDuration), band = (std::log(10.0) - first) / kBands;
  std::vector<std::vector<int>> lines(kBands);
  for (int b = 0; b < kBands; ++b) {
    for (int i = 0; i < kLinesOfBand; ++i) {
      const int line =
          static_cast<int>(std::lround(kDuration * std::exp(first + band * (b + (i + 0.5) / kLinesOfBand))));
      if (lines[b].empty() || line > lines[b].back()) lines[b].push_back(line);
    }
  }
  std::vector<double> measured(kBands, 0.0), exact(kBands, 0.0);
  constexpr std::array kFrequencies = {12, 60};  // 0.02 and 0.1 Hz
  std::array<std::array<std::complex<double>, 2>, 2> cross = {};
  std::array<std::array<double, 3>, 2> power = {};
  for (int seed = 1; seed <= seeds; ++seed) {
    const Eigen::MatrixXd along =
        wind_series(profile, series_options, static_cast<std::uint64_t>(seed)).velocity[0];
    for (int b = 0; b < kBands; ++b)
      for (const int line : lines[b])
        measured[b] += 2.0 / kDuration * std::norm(transform_at(along.col(0), line)) / seeds;
    for (std::size_t n = 0; n < kFrequencies.size(); ++n) {
      for (int side = -1; side <= 1; ++side) {
        std::array<std::complex<double>, 3> at;
        for (Eigen::Index i = 0; i < 3; ++i) {
          at[static_cast<std::size_t>(i)] = transform_at(along.col(i), kFrequencies[n] + side);
          power[n][static_cast<std::size_t>(i)] += std::norm(at[static_cast<std::size_t>(i)]);
        }
        for (std::size_t i = 0; i < 2; ++i) cross[n][i] += at[0] * std::conj(at[i + 1]);
      }
    }
  }
  double band_error = 0.0, coherence_error = 0.0;
  for (int b = 0; b < kBands; ++b) {
    for (const int line : lines[b])
      exact[b] += iec_spectrum(Component::along, line / kDuration, 30.0, 10.0, kAlongDeviation);
    band_error = std::max(band_error, std::abs(measured[b] / exact[b] - 1.0));
  }
  for (std::size_t n = 0; n < kFrequencies.size(); ++n) {
    for (std::size_t i = 0; i < 2; ++i) {
      const double found = cross[n][i].real() / std::sqrt(power[n][0] * power[n][i + 1]);
      const double expected =
          wind_coherence(Component::along, kFrequencies[n] / kDuration, i == 0 ? 5.0 : 15.0, 30.0, 10.0);
      coherence_error = std::max(coherence_error, std::abs(found - expected));
    }
  }
  const auto show = [](const char* metric, double value) {
    print({.bench = "wind",
           .test_case = "series_iec",
           .metric = metric,
           .value = value,
           .baseline = "IEC 61400-1"});
  };
  show("band_error", band_error);
  show("coherence_error", coherence_error);
}

}  // namespace samara::benchmarks
