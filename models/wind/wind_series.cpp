#include "samara/models/wind/wind_series.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <fmt/format.h>
#include <unsupported/Eigen/FFT>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/base/streams.h"

namespace samara::models::wind {

namespace {

constexpr std::array kComponents = {Component::along, Component::across, Component::vertical};
/// Series draw from streams of their own, see wind_modes.cpp.
constexpr std::uint64_t kSeriesStreams = std::uint64_t{0x53455249} << 32;
constexpr double kMostPoints = 1000;
/// The transform takes as many operations a sample as the largest prime factor of their number.
constexpr long kLargestFactor = 1000;

long largest_prime_factor(long n) {
  long largest = 1;
  for (long p = 2; p * p <= n; ++p) {
    for (; n % p == 0; n /= p) largest = p;
  }
  return std::max(largest, n);
}

void check_series(const WindProfile& profile, const SeriesOptions& options) {
  require_positive(options.step, "the step of the series [s]");
  require(options.samples >= 4, "the number of samples", options.samples, "at least 4");
  if (options.spectrum == SeriesSpectrum::iec)
    require_positive(options.sigma, "the deviation along the wind [m/s]");
  else
    require_positive(profile.friction_velocity(), "the friction velocity [m/s]");
  require(options.points.cols() >= 1, "the number of points", options.points.cols(), "at least 1");
  const double numbers =
      3.0 * static_cast<double>(options.samples) * static_cast<double>(options.points.cols());
  if (numbers > kMostSeriesNumbers) {
    throw ArgumentError(
        fmt::format("{} samples at {} points take {:.3g} numbers, some {:.0f} MB; at most {:.0g} were "
                    "expected",
                    options.samples, options.points.cols(), numbers, 60e-6 * numbers, kMostSeriesNumbers));
  }
  require(static_cast<double>(options.points.cols()) <= kMostPoints, "the number of points",
          options.points.cols(), "at most 1000");
  if (largest_prime_factor(options.samples) > kLargestFactor) {
    long better = options.samples + 1;
    while (largest_prime_factor(better) > kLargestFactor) ++better;
    throw ArgumentError(
        fmt::format("the number of samples is {}, of which {} is a prime factor: their transform would "
                    "take too long; {} would do",
                    options.samples, largest_prime_factor(options.samples), better));
  }
  for (Eigen::Index i = 0; i < options.points.cols(); ++i) {
    const auto point = options.points.col(i);
    require(point.allFinite(), fmt::format("a coordinate of point {} [m]", i + 1), point.sum(),
            "a finite number");
    require(point.z() > 0.0, fmt::format("the height of point {} [m]", i + 1), point.z(), "more than 0");
    if (profile.speed(point.z()) > 0.0) continue;
    throw ArgumentError(fmt::format(
        "the mean wind at point {}, {:.6g} m above the ground, is 0; a point where it blows was expected",
        i + 1, point.z()));
  }
}

double distance_across(const Eigen::Matrix3Xd& points, Eigen::Index i, Eigen::Index j) {
  return (points.col(i) - points.col(j)).tail<2>().norm();
}

/// L with L L^T = coherences; a column of zeros where points coincide, which a matrix of full rank does not have.
void factorise(Eigen::MatrixXd& coherences) {
  constexpr double kLeast = 1e-12;
  Eigen::MatrixXd& L = coherences;
  for (Eigen::Index j = 0; j < L.cols(); ++j) {
    const Eigen::Index below = L.rows() - j;
    L.col(j).tail(below) -= L.bottomLeftCorner(below, j) * L.row(j).head(j).transpose();
    const double pivot = L(j, j);
    if (pivot > kLeast)
      L.col(j).tail(below) /= std::sqrt(pivot);
    else
      L.col(j).tail(below).setZero();
    L.col(j).head(j).setZero();
  }
}

/// Turbulence of one component at all points: one column each.
class SeriesMaker {
 public:
  SeriesMaker(const WindProfile& profile, const SeriesOptions& options)
      : profile_(profile),
        options_(options),
        reference_(coherence_reference(profile, options.points)),
        spectra_(options.samples, options.points.cols()) {}

  Eigen::MatrixXd component(Component component, Stream& random) {
    const Eigen::Index points = options_.points.cols();
    const double df = 1.0 / (options_.step * static_cast<double>(options_.samples));
    Eigen::MatrixXd mix(points, points);
    Eigen::VectorXcd amplitudes(points);
    spectra_.setZero();
    for (long line = 1; line < (options_.samples + 1) / 2; ++line) {
      const double n = df * static_cast<double>(line);
      for (Eigen::Index j = 0; j < points; ++j) {
        for (Eigen::Index i = j; i < points; ++i)
          mix(i, j) = wind_coherence(component, n, distance_across(options_.points, i, j), reference_.height,
                                     reference_.speed);
        const double cosine = random.normal();
        amplitudes[j] = {cosine, random.normal()};
      }
      factorise(mix);
      amplitudes = mix * amplitudes;
      for (Eigen::Index i = 0; i < points; ++i) {
        const double S = series_spectrum(profile_, options_, component, n, options_.points(2, i));
        const double delay = 2.0 * std::numbers::pi * n * options_.points(0, i) / reference_.speed;
        spectra_(line, i) = std::sqrt(S * df) * amplitudes[i] * std::polar(1.0, -delay);
      }
    }
    return transformed();
  }

 private:
  Eigen::MatrixXd transformed() {
    Eigen::FFT<double> transform;
    transform.SetFlag(Eigen::FFT<double>::Unscaled);
    Eigen::MatrixXd series(spectra_.rows(), spectra_.cols());
    Eigen::VectorXcd from, to;
    for (Eigen::Index i = 0; i < spectra_.cols(); ++i) {
      from = spectra_.col(i);
      transform.inv(to, from);
      series.col(i) = to.real();
    }
    return series;
  }

  const WindProfile& profile_;
  const SeriesOptions& options_;
  CoherenceReference reference_;
  Eigen::MatrixXcd spectra_;
};

}  // namespace

double series_spectrum(const WindProfile& profile, const SeriesOptions& options, Component component,
                       double n, double z) {
  const double speed = profile.speed(z);
  if (options.spectrum == SeriesSpectrum::iec) return iec_spectrum(component, n, z, speed, options.sigma);
  return kaimal_spectrum(component, n, z - profile.options().displacement, speed,
                         profile.friction_velocity());
}

CoherenceReference coherence_reference(const WindProfile& profile, const Eigen::Matrix3Xd& points) {
  const double height = 0.5 * (points.row(2).minCoeff() + points.row(2).maxCoeff());
  return {.height = height, .speed = profile.speed(height)};
}

WindSeries wind_series(const WindProfile& profile, const SeriesOptions& options, std::uint64_t seed,
                       std::uint64_t realisation) {
  check_series(profile, options);
  WindSeries series;
  series.times = Eigen::VectorXd::LinSpaced(options.samples, 0.0, 1.0) *
                 (options.step * static_cast<double>(options.samples - 1));
  Stream random(seed, kSeriesStreams ^ realisation);
  SeriesMaker maker(profile, options);
  for (std::size_t c = 0; c < kComponents.size(); ++c)
    series.velocity[c] = maker.component(kComponents[c], random);
  for (Eigen::Index i = 0; i < options.points.cols(); ++i)
    series.velocity[0].col(i).array() += profile.speed(options.points(2, i));
  return series;
}

SeriesStatistics statistics_of(const WindSeries& series, const WindProfile& profile,
                               const SeriesOptions& options) {
  const Eigen::Index points = options.points.cols();
  const auto samples = static_cast<double>(series.times.size());
  const double df = 1.0 / (options.step * samples);
  SeriesStatistics statistics;
  statistics.mean.resize(3, points);
  statistics.deviation.resize(3, points);
  statistics.target.setZero(3, points);
  for (std::size_t c = 0; c < kComponents.size(); ++c) {
    const auto row = static_cast<Eigen::Index>(c);
    for (Eigen::Index i = 0; i < points; ++i) {
      const auto column = series.velocity[c].col(i);
      statistics.mean(row, i) = column.mean();
      statistics.deviation(row, i) = std::sqrt((column.array() - column.mean()).square().sum() / samples);
      for (long line = 1; line < (options.samples + 1) / 2; ++line) {
        statistics.target(row, i) +=
            df * series_spectrum(profile, options, kComponents[c], df * static_cast<double>(line),
                                 options.points(2, i));
      }
    }
  }
  statistics.target = statistics.target.cwiseSqrt();
  return statistics;
}

}  // namespace samara::models::wind
