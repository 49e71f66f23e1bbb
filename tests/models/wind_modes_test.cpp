#include "samara/models/wind/wind_modes.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <boost/math/special_functions/bessel.hpp>
#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/models/stochastic/fluid_seen.h"
#include "samara/models/wind/mode_sums.h"
#include "wind_statistics.h"

using namespace samara::models;
using namespace samara::models::wind;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kSigma = 1.2, kLength = 10.0;

ModeSpectrum unit_band(ModeOptions options = {}) {
  options.lowest = 0.02 / kLength;
  options.highest = 200.0 / kLength;
  return {VonKarmanSpectrum(kSigma, kLength), options};
}

double uniform_in(samara::Stream& random, double half_width) {
  return half_width * (2.0 * random.uniform() - 1.0);
}

Eigen::Vector3d place_in(samara::Stream& random, double half_width) {
  Eigen::Vector3d place;
  for (double& x : place) x = uniform_in(random, half_width);
  return place;
}

/// What a check of turbulence looks at: variance per component, D_LL over some ways, and the greatest divergence.
struct FieldStatistics {
  double variance = 0.0;
  std::array<double, 5> structure = {};
  double divergence = 0.0;  ///< over the size of the gradient
};
constexpr std::array<double, 5> kWays = {0.03, 0.1, 0.3, 1.0, 3.0};

/// @param field (realisation) -> (position) -> AmbientSample
template <class Field>
FieldStatistics field_statistics(int realisations, const Field& field) {
  FieldStatistics all;
  constexpr int kPlaces = 8;
  const double share = 1.0 / (realisations * kPlaces);
  for (int r = 0; r < realisations; ++r) {
    const auto flow = field(r);
    samara::Stream random(99, static_cast<std::uint64_t>(r));
    for (int i = 0; i < kPlaces; ++i) {
      const Eigen::Vector3d here = place_in(random, 100.0 * kLength);
      const Eigen::Vector3d way = place_in(random, 1.0).normalized();
      const AmbientSample at = flow(here);
      all.variance += share * at.velocity.squaredNorm() / 3.0;
      all.divergence = std::max(all.divergence, std::abs(at.gradient.trace()) / at.gradient.norm());
      for (std::size_t k = 0; k < kWays.size(); ++k) {
        const double change = way.dot(flow(here + kWays[k] * kLength * way).velocity - at.velocity);
        all.structure[k] += share * change * change;
      }
    }
  }
  return all;
}

/// The statement of the checks below: the variance of the band within 1.5 %, D_LL within 3 % from 0.03 L to 3 L, no
/// divergence.
bool is_turbulence(const FieldStatistics& statistics, const ModeSpectrum& spectrum) {
  const double variance = kSigma * kSigma * spectrum.variance_share();
  bool holds = std::abs(statistics.variance / variance - 1.0) < 0.015 && statistics.divergence < 1e-6;
  for (std::size_t k = 0; k < kWays.size(); ++k) {
    const double exact = spectrum.spectrum().structure_function(kWays[k] * kLength, spectrum.options().lowest,
                                                                spectrum.options().highest);
    holds = holds && std::abs(statistics.structure[k] / exact - 1.0) < 0.03;
  }
  return holds;
}

}  // namespace

TEST_CASE("600 realisations of 200 modes have the variance and the structure function of their band") {
  const ModeSpectrum spectrum = unit_band();
  const FieldStatistics statistics = field_statistics(600, [&](int r) {
    return [wind = WindModes(spectrum, 5, static_cast<std::uint64_t>(r))](const Eigen::Vector3d& place) {
      return wind.sample(0.0, place);
    };
  });
  const double variance = kSigma * kSigma * spectrum.variance_share();
  CHECK_THAT(spectrum.variance_share(), WithinAbs(0.9575, 1e-4));
  CHECK_THAT(statistics.variance, WithinRel(variance, 0.015));
  for (std::size_t k = 0; k < kWays.size(); ++k) {
    CHECK_THAT(statistics.structure[k],
               WithinRel(spectrum.spectrum().structure_function(kWays[k] * kLength, 0.002, 20.0), 0.03));
  }
  CHECK(statistics.divergence < 1e-12);
  CHECK(is_turbulence(statistics, spectrum));
}

TEST_CASE("independent components of the right variance do not pass for turbulence") {
  // Each component by modes of its own: all of variance, spectrum and isotropy in the mean, no field of a fluid.
  const ModeSpectrum spectrum = unit_band();
  const FieldStatistics independent = field_statistics(200, [&](int r) {
    const auto number = static_cast<std::uint64_t>(r);
    return [parts = std::array{WindModes(spectrum, 5, number), WindModes(spectrum, 6, number),
                               WindModes(spectrum, 7, number)}](const Eigen::Vector3d& place) {
      AmbientSample sample;
      for (int i = 0; i < 3; ++i) {
        const AmbientSample part = parts[static_cast<std::size_t>(i)].sample(0.0, place);
        sample.velocity[i] = part.velocity[i];
        sample.gradient.row(i) = part.gradient.row(i);
      }
      return sample;
    };
  });
  CHECK_THAT(independent.variance, WithinRel(kSigma * kSigma * spectrum.variance_share(), 0.05));
  CHECK(independent.divergence > 0.1);
  CHECK_FALSE(is_turbulence(independent, spectrum));
}

TEST_CASE(
    "across a wave number the spectrum is 4/3 of that along it, which filtered white noise does not show") {
  const ModeSpectrum spectrum = unit_band();
  const VonKarmanSpectrum& exact = spectrum.spectrum();
  // Wave numbers along x between 8 and 16/L, far inside the band: that it ends raises the ratio by 1 %.
  const auto ratio_of = [&](const auto& field) {
    return line_spectra(300, 0.02 * kLength, 2048, 8.0 / kLength, 16.0 / kLength, field);
  };
  const LineSpectra modes = ratio_of([&](int r) {
    return [wind = WindModes(spectrum, 8, static_cast<std::uint64_t>(r))](double x) -> Eigen::Vector3d {
      return wind.sample(0.0, {x, 1.0, 2.0}).velocity;
    };
  });
  const double expected = exact.transverse(12.0 / kLength) / exact.longitudinal(12.0 / kLength);
  CHECK_THAT(expected, WithinAbs(4.0 / 3.0, 0.02));
  CHECK_THAT(modes.transverse_over_longitudinal(), WithinRel(4.0 / 3.0, 0.04));

  const LineSpectra noise =
      ratio_of([&](int r) { return FilteredNoise(kSigma, kLength, 0.02 * kLength, 2048, r); });
  CHECK_THAT(noise.variance, WithinRel(kSigma * kSigma, 0.05));  // right so far
  CHECK_FALSE(std::abs(noise.transverse_over_longitudinal() / (4.0 / 3.0) - 1.0) < 0.04);
}

TEST_CASE("gradient and rate of a wind are its differences, alone and averaged over an ellipse") {
  for (const bool frozen : {false, true}) {
    const ModeSpectrum spectrum = unit_band({.frozen = frozen, .convection = {4.0, 1.0, 0.0}});
    const WindModes wind(spectrum, 3, 7);
    const Ellipse ellipse = {.first = {0.3, 0.1, 0.0}, .second = {-0.05, 0.15, 0.1}};
    samara::Stream random(4, 0);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d here = place_in(random, 50.0);
      const double t = uniform_in(random, 20.0);
      const auto compare = [&](const auto& at) {
        const AmbientSample sample = at(t, here);
        const double size = sample.gradient.norm();
        const double h = 1e-5;
        for (int j = 0; j < 3; ++j) {
          const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(j);
          const Eigen::Vector3d slope =
              (at(t, here + step).velocity - at(t, here - step).velocity) / (2.0 * h);
          CHECK((slope - sample.gradient.col(j)).norm() < 1e-6 * size);
        }
        const Eigen::Vector3d rate = (at(t + h, here).velocity - at(t - h, here).velocity) / (2.0 * h);
        CHECK((rate - sample.rate).norm() <
              1e-6 * size * 5.0);  // at 5 m/s the rate is 5 m/s times a gradient
        CHECK(std::abs(sample.gradient.trace()) < 1e-12 * size);
      };
      compare([&](double at_t, const Eigen::Vector3d& at) { return wind.sample(at_t, at); });
      compare([&](double at_t, const Eigen::Vector3d& at) { return wind.mean_over(ellipse, at_t, at); });
    }
  }
}

TEST_CASE("a frozen field is carried along, and one that is swept loses itself within an eddy's passing") {
  const Eigen::Vector3d convection(4.0, 1.0, 0.0);
  const Eigen::Vector3d here(3.0, 2.0, 1.0);
  const WindModes frozen(unit_band({.frozen = true, .convection = convection}), 3, 1);
  CHECK((frozen.sample(7.0, here + 7.0 * convection).velocity - frozen.sample(0.0, here).velocity).norm() <
        1e-10);
  // Following the mean wind, <u(0) u(t)>/sigma^2 of a mode falls as exp(-(0.4 sigma k t)^2/2).
  const ModeSpectrum spectrum = unit_band({.convection = convection});
  // 2 E(k) of the band, by the trapezoidal rule in ln k: no strata.
  const double low = std::log(spectrum.options().lowest), high = std::log(spectrum.options().highest);
  const auto exact = [&](double t, double sweeping) {
    constexpr int kIntervals = 4000;
    double sum = 0.0;
    for (int i = 0; i <= kIntervals; ++i) {
      const double k = std::exp(low + (high - low) * i / kIntervals), phase = sweeping * kSigma * k * t;
      sum += (i % kIntervals == 0 ? 0.5 : 1.0) * 2.0 * k * spectrum.spectrum().energy(k) *
             std::exp(-0.5 * phase * phase);
    }
    return sum * (high - low) / kIntervals;
  };
  constexpr int kRealisations = 6000;
  // Three components, 6000 draws: sigma^2 sqrt(3/6000) = 0.022 each time, and a factor of the size of u^2's own
  // scatter.
  const double tolerance = 4.0 * kSigma * kSigma * std::sqrt(2.0 * 3.0 / kRealisations);
  for (const double times : {0.5, 1.0}) {
    const double t = times * kLength / kSigma;
    double correlation = 0.0;
    for (int r = 0; r < kRealisations; ++r) {
      const WindModes wind(spectrum, 3, static_cast<std::uint64_t>(r));
      correlation +=
          wind.sample(t, here + t * convection).velocity.dot(wind.sample(0.0, here).velocity) / kRealisations;
    }
    CHECK_THAT(correlation, WithinAbs(exact(t, 0.4), tolerance));
    // Far enough from sweeping that is half as strong, or half as strong again.
    CHECK(std::abs(exact(t, 0.2) - exact(t, 0.4)) > tolerance);
    CHECK(std::abs(exact(t, 0.6) - exact(t, 0.4)) > tolerance);
  }
}

TEST_CASE("what a disc sees of the modes is what the quadrature over the spectrum says") {
  // Modes with their own spectrum, the normal component, 0.1 L; the band's own share by the same factors.
  const ModeSpectrum spectrum = unit_band();
  const double a = 0.1 * kLength;
  const Ellipse disc = {.first = {a, 0.0, 0.0}, .second = {0.0, a, 0.0}};
  double whole = 0.0, mean = 0.0;
  constexpr int kRealisations = 3000;
  for (int r = 0; r < kRealisations; ++r) {
    const WindModes wind(spectrum, 12, static_cast<std::uint64_t>(r));
    const Eigen::Vector3d here(0.3 * r, 1.0, -2.0);
    whole += std::pow(wind.sample(0.0, here).velocity.z(), 2);
    mean += std::pow(wind.mean_over(disc, 0.0, here).velocity.z(), 2);
  }
  // Of the 4.25 % of the variance above the band the disc keeps nothing.
  const double expected = disc_attenuation(0.1) / spectrum.variance_share();
  CHECK_THAT(mean / whole, WithinAbs(expected, 0.01));
}

TEST_CASE("a wave over an ellipse is weakened by 2 J1(q)/q of its own q") {
  // One mode: the ratio of means and values is the factor, the same at all places.
  const ModeSpectrum spectrum(VonKarmanSpectrum(kSigma, kLength),
                              {.modes = 1, .lowest = 1.0, .highest = 30.0});
  for (std::uint64_t r = 0; r < 30; ++r) {
    const WindModes wind(spectrum, 1, r);
    const Eigen::Vector3d here(0.2, 0.5, 0.1);
    const AmbientSample sample = wind.sample(0.0, here);
    const Ellipse ellipse = {.first = {0.5, 0.0, 0.1}, .second = {0.0, 0.2, 0.0}};
    // k from the gradient: row i is (d u_i/d phase) k.
    Eigen::Index row = 0;
    sample.gradient.rowwise().norm().maxCoeff(&row);
    const Eigen::Vector3d direction = sample.gradient.row(row).transpose().normalized();
    const Eigen::Vector3d u0 = sample.velocity;
    // u'' = -k^2 u along k
    const double h = 1e-4;
    const Eigen::Vector3d second = (wind.sample(0.0, here + h * direction).velocity - 2.0 * u0 +
                                    wind.sample(0.0, here - h * direction).velocity) /
                                   (h * h);
    const double k = std::sqrt(-second.dot(u0) / u0.squaredNorm());
    const double q = k * std::hypot(direction.dot(ellipse.first), direction.dot(ellipse.second));
    CHECK((wind.mean_over(ellipse, 0.0, here).velocity - 2.0 * boost::math::cyl_bessel_j(1, q) / q * u0)
              .norm() < 1e-5 * u0.norm());
  }
}

TEST_CASE("a stretched field has deviations by component, and the divergence that is said of it") {
  const Eigen::Vector3d ratios(1.0, 0.8, 0.5);
  const ModeSpectrum spectrum = unit_band({.stretch = ratios.asDiagonal()});
  CHECK_THAT(spectrum.divergence(), WithinAbs(std::sqrt((3.0 * 1.89 - 2.3 * 2.3) / 18.9), 1e-12));
  CHECK(unit_band().divergence() < 1e-8);
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  double divergence = 0.0, gradient = 0.0;
  constexpr int kRealisations = 2000;
  for (int r = 0; r < kRealisations; ++r) {
    const AmbientSample sample =
        WindModes(spectrum, 2, static_cast<std::uint64_t>(r)).sample(0.0, {1.0, 2.0, 3.0});
    squares += sample.velocity.array().square() / kRealisations;
    divergence += std::pow(sample.gradient.trace(), 2);
    gradient += sample.gradient.squaredNorm();
  }
  const double variance = kSigma * kSigma * spectrum.variance_share();
  for (int i = 0; i < 3; ++i) CHECK_THAT(squares[i], WithinRel(variance * ratios[i] * ratios[i], 0.1));
  CHECK_THAT(std::sqrt(divergence / gradient), WithinRel(spectrum.divergence(), 0.1));
}

TEST_CASE("a realisation has the same bits alone and among others, and realisations are independent") {
  const ModeSpectrum spectrum = unit_band();
  const Eigen::Vector3d here(1.0, 2.0, 3.0);
  std::vector<Eigen::Vector3d> values;
  for (std::uint64_t r = 0; r < 2000; ++r)
    values.push_back(WindModes(spectrum, 21, r).sample(0.5, here).velocity);
  CHECK(WindModes(spectrum, 21, 1234).sample(0.5, here).velocity == values[1234]);
  CHECK(WindModes(spectrum, 22, 1234).sample(0.5, here).velocity != values[1234]);
  CHECK(WindModes(spectrum, 21, 77, true).sample(0.5, here).velocity == -values[77]);
  double neighbours = 0.0, components = 0.0;
  for (std::size_t r = 0; r + 1 < values.size(); ++r) {
    neighbours += values[r].dot(values[r + 1]) / (3.0 * kSigma * kSigma);
    components += values[r].x() * values[r].y() / (kSigma * kSigma);
  }
  const auto draws = static_cast<double>(values.size());
  CHECK(std::abs(neighbours) < 4.0 * std::sqrt(draws / 3.0));
  CHECK(std::abs(components) < 4.0 * std::sqrt(draws));
}

TEST_CASE("modes have the sines and cosines of the library, at phases small and large") {
  // One mode of the frequency x and no wave vector at t = 1: its cosine along x, its sine along y.
  const auto mode_at = [](double x) {
    std::array<double, kModeRows* kModeLanes> numbers = {};
    const std::size_t lane = 3;
    numbers[3 * kModeLanes + lane] = x;
    numbers[4 * kModeLanes + lane] = 1.0;
    numbers[8 * kModeLanes + lane] = 1.0;
    ModeSum sum = {};
    const double origin[3] = {};
    sum_modes({.numbers = numbers.data(), .count = kModeLanes}, origin, 1.0, sum);
    return std::array{sum.velocity[0], sum.velocity[1]};
  };
  samara::Stream random(2026, 5);
  std::vector<double> phases = {0.0,  1e-300, 1e-9, 1.5707963267948966, 1.5707963277948966, 3.141592653589793,
                                22.0, 355.0};
  for (int i = 0; i < 300; ++i) phases.push_back(std::pow(10.0, -3.0 + 8.0 * random.uniform()));
  for (const double phase : phases) {
    for (const double x : {phase, -phase}) {
      const auto [cosine, sine] = mode_at(x);
      CAPTURE(x);
      CHECK(std::abs(cosine - std::cos(x)) < 5e-16);
      CHECK(std::abs(sine - std::sin(x)) < 5e-16);
    }
  }
}

TEST_CASE("modes that make no turbulence are refused") {
  const VonKarmanSpectrum spectrum(1.0, 1.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(ModeSpectrum(spectrum, {.modes = 0, .highest = 10.0}),
                    "the number of modes is 0; 1 to 100000 was expected");
  CHECK_THROWS_WITH(ModeSpectrum(spectrum, {}),
                    "the highest wave number [rad/m] is 0; a positive finite number was expected");
  CHECK_THROWS_WITH(ModeSpectrum(spectrum, {.lowest = 3.0, .highest = 2.0}),
                    "the highest wave number [rad/m] is 2; more than the lowest was expected");
  CHECK_THROWS_AS(ModeSpectrum(spectrum, {.highest = nan}), samara::ArgumentError);
  CHECK_THROWS_AS(ModeSpectrum(spectrum, {.highest = 10.0, .stretch = Eigen::Matrix3d::Zero()}),
                  samara::ArgumentError);
  Eigen::Matrix3d skew = Eigen::Matrix3d::Identity();
  skew(0, 1) = 0.1;
  CHECK_THROWS_AS(ModeSpectrum(spectrum, {.highest = 10.0, .stretch = skew}), samara::ArgumentError);
  CHECK_THROWS_AS(ModeSpectrum(spectrum, {.lowest = nan, .highest = 1.0}), samara::ArgumentError);
  CHECK_THROWS_AS(ModeSpectrum(spectrum, {.highest = 10.0, .convection = {0.0, nan, 0.0}}),
                  samara::ArgumentError);
}
