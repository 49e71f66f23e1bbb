#include "samara/models/wind/wind_series.h"

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/base/streams.h"

using namespace samara::models::wind;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

const WindProfile kHub({.speed = 10.0, .height = 30.0});
constexpr double kAlongSigma = 1.7;

/// 600 s at 20 Hz, one point, or three in a row across the wind at one height: 0, 5 and 15 m.
SeriesOptions standard_series(int points) {
  SeriesOptions options{
      .sigma = kAlongSigma, .step = 0.05, .samples = 12000, .points = Eigen::Matrix3Xd::Zero(3, points)};
  options.points.row(2).setConstant(30.0);
  if (points == 3) options.points.row(1) << 0.0, 5.0, 15.0;
  return options;
}

/// Multiples of 1/duration that lie closest to equal steps in ln n, each once.
std::vector<int> lines_between(double lowest, double highest, int count, double duration) {
  std::vector<int> lines;
  const double first = std::log(lowest), range = std::log(highest / lowest);
  for (int i = 0; i < count; ++i) {
    const int line = static_cast<int>(std::lround(duration * std::exp(first + range * (i + 0.5) / count)));
    if (lines.empty() || line > lines.back()) lines.push_back(line);
  }
  return lines;
}

/// sum of x_j exp(-i 2 pi n j step) step
std::complex<double> transform_at(const Eigen::VectorXd& x, double n, double step) {
  const std::complex<double> turn = std::polar(1.0, -2.0 * std::numbers::pi * n * step);
  std::complex<double> sum = 0.0, factor = 1.0;
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    if (j % 512 == 0) factor = std::polar(1.0, -2.0 * std::numbers::pi * n * step * static_cast<double>(j));
    sum += x[j] * factor;
    factor *= turn;
  }
  return sum * step;
}

/// The real part of the coherence of points a and b about a frequency, over series of many seeds.
template <class Series>
double coherence_of(int seeds, double step, double n, Eigen::Index a, Eigen::Index b, const Series& series) {
  std::complex<double> cross = 0.0;
  double power_a = 0.0, power_b = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Eigen::MatrixXd along = series(seed);
    const double duration = step * static_cast<double>(along.rows());
    for (int line = -3; line <= 3; ++line) {
      const double at = n + line / duration;
      const std::complex<double> A = transform_at(along.col(a), at, step),
                                 B = transform_at(along.col(b), at, step);
      cross += A * std::conj(B);
      power_a += std::norm(A);
      power_b += std::norm(B);
    }
  }
  return cross.real() / std::sqrt(power_a * power_b);
}

/// Of 5 m and 15 m at 0.02 and 0.1 Hz, U = 10 m/s, L_c = 170.1 m: exp(-12 hypot(n r/U, 0.12 r/L_c)).
bool has_coherence(double near_low, double near_high, double far_low, double far_high) {
  return std::abs(near_low - 0.8805) < 0.03 && std::abs(near_high - 0.5480) < 0.03 &&
         std::abs(far_low - 0.6827) < 0.03 && std::abs(far_high - 0.1646) < 0.03;
}

}  // namespace

TEST_CASE("series of the standard have its variance and its spectrum in every band") {
  const SeriesOptions options = standard_series(1);
  constexpr int kSeeds = 200, kBands = 12;
  const double duration = 600.0;
  const double first = std::log(1.0 / duration), last = std::log(10.0);
  std::vector<double> measured(kBands, 0.0), exact(kBands, 0.0);
  double variance = 0.0, target = 0.0;
  // A few lines of every band, of its 1.5 to 3000; and more of those between 0.5 and 8 Hz, for the slope there.
  const std::vector<int> lines = lines_between(1.0 / duration, 10.0, 10 * kBands, duration);
  const std::vector<int> sloping = lines_between(0.5, 8.0, 300, duration);
  const auto band_of = [&](double n) {
    return std::min<std::size_t>(kBands - 1,
                                 static_cast<std::size_t>((std::log(n) - first) / (last - first) * kBands));
  };
  std::vector<double> power(lines.size(), 0.0), sloping_power(sloping.size(), 0.0);
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const WindSeries series = wind_series(kHub, options, seed);
    const Eigen::VectorXd gust = series.velocity[0].col(0).array() - 10.0;
    variance += gust.squaredNorm() / static_cast<double>(gust.size()) / kSeeds;
    const auto add_power = [&](const std::vector<int>& of, std::vector<double>& to) {
      for (std::size_t i = 0; i < of.size(); ++i)
        to[i] += 2.0 / duration * std::norm(transform_at(gust, of[i] / duration, options.step)) / kSeeds;
    };
    add_power(lines, power);
    add_power(sloping, sloping_power);
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double n = lines[i] / duration;
    measured[band_of(n)] += power[i];
    exact[band_of(n)] += iec_spectrum(Component::along, n, 30.0, 10.0, kAlongSigma);
  }
  for (std::size_t band = 0; band < kBands; ++band) {
    INFO("band " << band << ": " << measured[band] / exact[band]);
    // 200 seeds times the lines of the band, each of relative deviation 1: at three deviations.
    double in_band = 0.0;
    for (const int line : lines) in_band += band_of(line / duration) == band ? 1.0 : 0.0;
    CHECK(std::abs(measured[band] / exact[band] - 1.0) < std::max(0.03, 3.0 / std::sqrt(kSeeds * in_band)));
  }
  for (int line = 1; line < 6000; ++line)
    target += iec_spectrum(Component::along, line / duration, 30.0, 10.0, kAlongSigma) / duration;
  CHECK_THAT(target, WithinRel(0.936 * kAlongSigma * kAlongSigma, 1e-3));
  CHECK_THAT(variance, WithinRel(target, 0.02));
  // A line's mean over 200 seeds scatters by 0.07 in ln S, so the slope by 0.07/(0.8 sqrt(300)) = 0.005, as ln n does
  // by 0.8. The spectrum itself has -1.656 there.
  double sum = 0.0, x_sum = 0.0, y_sum = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < sloping.size(); ++i) {
    const double x = std::log(sloping[i] / duration), y = std::log(sloping_power[i]);
    sum += 1.0, x_sum += x, y_sum += y, xx += x * x, xy += x * y;
  }
  CHECK_THAT((xy - x_sum * y_sum / sum) / (xx - x_sum * x_sum / sum), WithinAbs(-1.66, 0.02));
}

TEST_CASE("points across the wind cohere as the standard says, which filtered noise does not") {
  SeriesOptions options = standard_series(3);
  options.step = 0.2;
  options.samples = 3000;
  constexpr int kSeeds = 400;
  std::vector<Eigen::MatrixXd> all;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed)
    all.push_back(wind_series(kHub, options, seed).velocity[0]);
  const auto of_wind = [&](double n, Eigen::Index b) {
    return coherence_of(kSeeds, 0.2, n, 0, b, [&](int seed) -> const Eigen::MatrixXd& {
      return all[static_cast<std::size_t>(seed - 1)];
    });
  };
  const double near_low = of_wind(0.02, 1), near_high = of_wind(0.1, 1), far_low = of_wind(0.02, 2),
               far_high = of_wind(0.1, 2);
  CHECK_THAT(near_low, WithinAbs(0.8805, 0.03));
  CHECK_THAT(near_high, WithinAbs(0.5480, 0.03));
  CHECK_THAT(far_low, WithinAbs(0.6827, 0.03));
  CHECK_THAT(far_high, WithinAbs(0.1646, 0.03));
  CHECK(has_coherence(near_low, near_high, far_low, far_high));

  // A toy: low-passed white noise, mixed between the points to the right correlation of values.
  const auto of_noise = [&](double n, Eigen::Index b) {
    return coherence_of(100, 0.05, n, 0, b, [&](int seed) {
      samara::Stream random(31, static_cast<std::uint64_t>(seed));
      Eigen::MatrixXd noise(3000, 3);
      Eigen::Vector3d state = Eigen::Vector3d::Zero();
      const double near = 0.75, far = 0.45;  // sigma-weighted means of the coherences
      for (Eigen::Index j = 0; j < noise.rows(); ++j) {
        const double z[3] = {random.normal(), random.normal(), random.normal()};
        const Eigen::Vector3d mixed(z[0], near * z[0] + std::sqrt(1.0 - near * near) * z[1],
                                    far * z[0] + std::sqrt(1.0 - far * far) * z[2]);
        state = 0.99 * state + mixed;
        noise.row(j) = state.transpose();
      }
      return noise;
    });
  };
  CHECK_FALSE(has_coherence(of_noise(0.02, 1), of_noise(0.1, 1), of_noise(0.02, 2), of_noise(0.1, 2)));
}

TEST_CASE("a point downwind has the series of the one before it, later by the way at the mean speed") {
  SeriesOptions options = standard_series(1);
  options.samples = 2000;
  options.points.resize(3, 2);
  options.points << 0.0, 20.0, 0.0, 0.0, 30.0, 30.0;  // 20 m at 10 m/s: 2 s, 40 samples
  const WindSeries series = wind_series(kHub, options, 4);
  for (const Eigen::MatrixXd& velocity : series.velocity) {
    for (Eigen::Index j = 0; j + 40 < velocity.rows(); j += 17)
      CHECK_THAT(velocity(j + 40, 1), WithinAbs(velocity(j, 0), 1e-9));
  }
}

TEST_CASE("series of Kaimal's spectra have the deviations of the surface layer at every height") {
  const WindProfile profile({.speed = 8.0, .height = 10.0, .roughness = 0.1});
  SeriesOptions options{.spectrum = SeriesSpectrum::kaimal, .step = 0.1, .samples = 6000};
  options.points.resize(3, 2);
  options.points << 0.0, 0.0, 0.0, 0.0, 5.0, 40.0;
  Eigen::Matrix3Xd variance = Eigen::Matrix3Xd::Zero(3, 2), target;
  constexpr int kSeeds = 60;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const WindSeries series = wind_series(profile, options, seed);
    const SeriesStatistics statistics = statistics_of(series, profile, options);
    CHECK_THAT(statistics.mean(0, 1), WithinRel(profile.speed(40.0), 1e-12));
    variance += statistics.deviation.cwiseAbs2() / kSeeds;
    target = statistics.target.cwiseAbs2();
  }
  for (Eigen::Index c = 0; c < 3; ++c)
    for (Eigen::Index i = 0; i < 2; ++i) CHECK_THAT(variance(c, i), WithinRel(target(c, i), 0.08));
  const double u2 = std::pow(profile.friction_velocity(), 2);
  CHECK(target(0, 0) < 4.7727 * u2);
  CHECK(target(0, 0) > 0.85 * 4.7727 * u2);
}

TEST_CASE("a series has the same bits for the same seed, and others for another") {
  SeriesOptions options = standard_series(3);
  options.samples = 100;
  CHECK(wind_series(kHub, options, 1, 3).velocity[2] == wind_series(kHub, options, 1, 3).velocity[2]);
  CHECK(wind_series(kHub, options, 1, 3).velocity[2] != wind_series(kHub, options, 1, 4).velocity[2]);
  CHECK(wind_series(kHub, options, 2, 3).velocity[2] != wind_series(kHub, options, 1, 3).velocity[2]);
}

TEST_CASE("a series that cannot be is refused with what is wrong") {
  const SeriesOptions good = standard_series(1);
  SeriesOptions options = good;
  options.sigma = 0.0;
  CHECK_THROWS_WITH(wind_series(kHub, options, 1),
                    "the deviation along the wind [m/s] is 0; a positive finite number was expected");
  options = good;
  options.step = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(wind_series(kHub, options, 1), samara::ArgumentError);
  options = good;
  options.samples = 3;
  CHECK_THROWS_WITH(wind_series(kHub, options, 1), "the number of samples is 3; at least 4 was expected");
  options = good;
  options.points.resize(3, 0);
  CHECK_THROWS_WITH(wind_series(kHub, options, 1), "the number of points is 0; at least 1 was expected");
  options = good;
  options.points(2, 0) = 0.02;
  CHECK_THROWS_WITH(
      wind_series(kHub, options, 1),
      "the mean wind at point 1, 0.02 m above the ground, is 0; a point where it blows was expected");
  options = good;
  options.points(1, 0) = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(wind_series(kHub, options, 1), samara::ArgumentError);
  options = good;
  options.samples = 100000000;
  CHECK_THROWS_AS(wind_series(kHub, options, 1), samara::ArgumentError);
  options = good;
  options.spectrum = SeriesSpectrum::kaimal;
  CHECK_THROWS_AS(wind_series(WindProfile({.kind = ProfileKind::power, .speed = 5.0}), options, 1),
                  samara::ArgumentError);
}

TEST_CASE(
    "series whose numbers of samples or points would take the machine are refused, with what would do") {
  const WindProfile profile({.speed = 10.0, .height = 30.0, .roughness = 0.03});
  const auto of = [&](long samples, Eigen::Index points) {
    return wind_series(profile,
                       {.sigma = 1.0,
                        .step = 0.1,
                        .samples = samples,
                        .points = Eigen::Vector3d(0.0, 0.0, 30.0).replicate(1, points)},
                       1);
  };
  CHECK_THROWS_WITH(of(9'000'000, 1), Catch::Matchers::Contains("9000000 samples at 1 points take"));
  CHECK_THROWS_WITH(of(4, 1001), Catch::Matchers::Contains("the number of points"));
  // A prime: its transform would take as many operations as its square.
  CHECK_THROWS_WITH(of(100003, 1), Catch::Matchers::Contains("of which 100003 is a prime factor"));
  CHECK_THROWS_WITH(of(2 * 1009, 1), Catch::Matchers::Contains("2019 would do"));
  CHECK(of(997, 1).times.size() == 997);
}
