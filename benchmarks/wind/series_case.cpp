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

constexpr double kDuration = 600.0, kAlongDeviation = 1.7;

const WindProfile& hub() {
  static const WindProfile profile({.speed = 10.0, .height = 30.0});
  return profile;
}

/// Series at 30 m, at the given places across the wind.
SeriesOptions series_options(double step, const std::vector<double>& places) {
  SeriesOptions options{.sigma = kAlongDeviation, .step = step, .samples = std::lround(kDuration / step)};
  options.points.setConstant(3, static_cast<Eigen::Index>(places.size()), 30.0);
  options.points.row(0).setZero();
  options.points.row(1) = Eigen::Map<const Eigen::RowVectorXd>(places.data(), options.points.cols());
  return options;
}

/// The transform of a series at a multiple of 1/600 Hz, by the sum.
std::complex<double> transform_at(const Eigen::VectorXd& x, double step, int line) {
  const auto samples = static_cast<double>(x.size());
  const auto turned = [&](double times) {
    return std::polar(1.0, -2.0 * std::numbers::pi * std::fmod(line * times, samples) / samples);
  };
  const std::complex<double> turn = turned(1.0);
  std::complex<double> sum = 0.0, factor = 1.0;
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    if (j % 1000 == 0) factor = turned(static_cast<double>(j));
    sum += x[j] * factor;
    factor *= turn;
  }
  return step * sum;
}

/// The greatest error of the spectrum in twelve bands from 1/600 to 10 Hz, some lines of each.
double band_error(int seeds) {
  constexpr int kBands = 12, kLinesOfBand = 6;
  constexpr double kStep = 0.05;
  const double first = std::log(1.0 / kDuration), width = (std::log(10.0) - first) / kBands;
  std::vector<std::vector<int>> lines(kBands);
  for (std::size_t band = 0; band < kBands; ++band) {
    for (int i = 0; i < kLinesOfBand; ++i) {
      const double place = static_cast<double>(band) + (i + 0.5) / kLinesOfBand;
      const int line = static_cast<int>(std::lround(kDuration * std::exp(first + width * place)));
      if (lines[band].empty() || line > lines[band].back()) lines[band].push_back(line);
    }
  }
  std::vector<double> measured(kBands, 0.0), exact(kBands, 0.0);
  for (int seed = 1; seed <= seeds; ++seed) {
    const WindSeries series =
        wind_series(hub(), series_options(kStep, {0.0}), static_cast<std::uint64_t>(seed));
    for (std::size_t band = 0; band < kBands; ++band) {
      for (const int line : lines[band])
        measured[band] += 2.0 / kDuration * std::norm(transform_at(series.velocity[0], kStep, line)) / seeds;
    }
  }
  double worst = 0.0;
  for (std::size_t band = 0; band < kBands; ++band) {
    for (const int line : lines[band])
      exact[band] += iec_spectrum(Component::along, line / kDuration, 30.0, 10.0, kAlongDeviation);
    worst = std::max(worst, std::abs(measured[band] / exact[band] - 1.0));
  }
  return worst;
}

/// The greatest error of the coherence at 0.02 and 0.1 Hz, over 5 and 15 m.
double coherence_error(int seeds) {
  constexpr double kStep = 0.25;
  const std::vector<double> places = {0.0, 5.0, 15.0};
  constexpr std::array kLines = {12, 60};
  std::array<std::array<std::complex<double>, 3>, kLines.size()> cross = {};
  std::array<std::array<double, 3>, kLines.size()> power = {};
  for (int seed = 1; seed <= seeds; ++seed) {
    const Eigen::MatrixXd along =
        wind_series(hub(), series_options(kStep, places), static_cast<std::uint64_t>(seed)).velocity[0];
    for (std::size_t n = 0; n < kLines.size(); ++n) {
      for (int side = -1; side <= 1; ++side) {
        std::array<std::complex<double>, 3> at;
        for (std::size_t i = 0; i < 3; ++i) {
          at[i] = transform_at(along.col(static_cast<Eigen::Index>(i)), kStep, kLines[n] + side);
          power[n][i] += std::norm(at[i]);
          cross[n][i] += at[0] * std::conj(at[i]);
        }
      }
    }
  }
  double worst = 0.0;
  for (std::size_t n = 0; n < kLines.size(); ++n) {
    for (std::size_t i = 1; i < 3; ++i) {
      const double found = cross[n][i].real() / std::sqrt(power[n][0] * power[n][i]);
      const double exact = wind_coherence(Component::along, kLines[n] / kDuration, places[i], 30.0, 10.0);
      worst = std::max(worst, std::abs(found - exact));
    }
  }
  return worst;
}

}  // namespace

void series_case(const Options& options) {
  const auto show = [](const char* metric, double value) {
    print({.bench = "wind",
           .test_case = "series_iec",
           .metric = metric,
           .value = value,
           .baseline = "IEC 61400-1"});
  };
  show("band_error", band_error(options.quick ? 300 : 3000));
  show("coherence_error", coherence_error(options.quick ? 300 : 2000));
}

}  // namespace samara::benchmarks
