#include "samara/models/wind/wind_modes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/base/streams.h"
#include "samara/models/wind/mode_sums.h"

namespace samara::models::wind {

namespace {

constexpr int kSpectrumCells = 2048;
/// Deviation of the frequency of a mode, over sigma k.
constexpr double kSweeping = 0.4;
/// Fields of wind draw from streams of their own: the others of a seed are numbered from 0.
constexpr std::uint64_t kWindStreams = std::uint64_t{0x57494e44} << 32;

double density_of_log(const VonKarmanSpectrum& spectrum, const ModeOptions& band, double energy, double k) {
  return 0.5 * k * spectrum.energy(k) / energy + 0.5 / std::log(band.highest / band.lowest);
}

Eigen::Vector3d isotropic_direction(Stream& random) {
  const double z = 2.0 * random.uniform() - 1.0;
  const double angle = 2.0 * std::numbers::pi * random.uniform();
  const double across = std::sqrt(1.0 - z * z);
  return {across * std::cos(angle), across * std::sin(angle), z};
}

Eigen::Vector3d normal_across(Stream& random, const Eigen::Vector3d& direction) {
  Eigen::Vector3d v;
  for (double& component : v) component = random.normal();
  return v - v.dot(direction) * direction;
}

AmbientSample sample_of(const ModeSum& sum, const Eigen::Vector3d& convection) {
  AmbientSample here;
  here.velocity = Eigen::Map<const Eigen::Vector3d>(sum.velocity);
  here.gradient = Eigen::Map<const Eigen::Matrix3d>(sum.gradient);
  here.rate = Eigen::Map<const Eigen::Vector3d>(sum.rate) - here.gradient * convection;
  return here;
}

}  // namespace

ModeSpectrum::ModeSpectrum(const VonKarmanSpectrum& spectrum, const ModeOptions& options)
    : spectrum_(spectrum), options_(options) {
  if (options_.lowest == 0.0) options_.lowest = 0.02 / spectrum.length();
  require(options_.modes >= 1 && options_.modes <= kMostModes, "the number of modes", options_.modes,
          fmt::format("1 to {}", kMostModes));
  require_positive(options_.lowest, "the lowest wave number [rad/m]");
  require_positive(options_.highest, "the highest wave number [rad/m]");
  require(options_.highest > options_.lowest, "the highest wave number [rad/m]", options_.highest,
          "more than the lowest");
  for (const double component : options_.convection)
    require(std::isfinite(component), "the velocity with which eddies are carried [m/s]", component,
            "a finite number");
  const double stretched = options_.stretch.squaredNorm();
  require(stretched > 0.0 && std::isfinite(stretched), "the square of the stretch of the modes", stretched,
          "a positive finite number");
  for (const auto& [i, j] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) {
    const double one = options_.stretch(i, j), other = options_.stretch(j, i);
    if (std::abs(one - other) <= 1e-10 * std::sqrt(stretched)) continue;
    throw ArgumentError(
        fmt::format("the stretch of the modes is not symmetric: entry ({}, {}) is {:.6g}, ({}, {}) is {:.6g}",
                    i, j, one, j, i, other));
  }
  const double energy = 1.5 * spectrum.sigma() * spectrum.sigma() * variance_share();
  const double h = std::log(options_.highest / options_.lowest) / kSpectrumCells;
  shares_.assign(kSpectrumCells + 1, 0.0);
  for (int i = 0; i < kSpectrumCells; ++i) {
    const double middle = options_.lowest * std::exp((i + 0.5) * h);
    const auto at = static_cast<std::size_t>(i);
    shares_[at + 1] = shares_[at] + density_of_log(spectrum, options_, energy, middle);
  }
  const double all = shares_.back();
  for (double& share : shares_) share /= all;
}

double ModeSpectrum::variance_share() const {
  return spectrum_.variance_share(options_.lowest, options_.highest);
}

double ModeSpectrum::divergence() const {
  // Means over directions of k and over amplitudes across it: k'S(1 - kk')Sk against tr S^2 - k'S^2 k.
  const Eigen::Matrix3d& S = options_.stretch;
  const double squares = S.squaredNorm();
  return std::sqrt(std::max(0.0, (3.0 * squares - S.trace() * S.trace()) / (10.0 * squares)));
}

double ModeSpectrum::sweeping_speed() const {
  return options_.frozen ? 0.0 : kSweeping * spectrum_.sigma();
}

ModeSpectrum::Stratum ModeSpectrum::at_share(double share) const {
  const auto above = std::upper_bound(shares_.begin() + 1, shares_.end() - 1, share);
  const double cell_share = *above - *(above - 1);
  const double h = std::log(options_.highest / options_.lowest) / kSpectrumCells;
  const double place =
      static_cast<double>(above - shares_.begin()) - 1.0 + (share - *(above - 1)) / cell_share;
  const double k = options_.lowest * std::exp(place * h);
  // d(ln k)/d(share) within the cell: the mean of E dk over draws is exact whatever the table is.
  return {.wave_number = k, .energy = k * spectrum_.energy(k) * h / (cell_share * options_.modes)};
}

WindModes::WindModes(const ModeSpectrum& spectrum, std::uint64_t seed, std::uint64_t realisation,
                     bool mirrored)
    : convection_(spectrum.options().convection),
      length_(2.0 * std::numbers::pi / spectrum.options().highest) {
  const int modes = spectrum.options().modes;
  count_ = (static_cast<std::size_t>(modes) + kModeLanes - 1) / kModeLanes * kModeLanes;
  rows_.assign(kModeRows * count_, 0.0);
  Stream random(seed, kWindStreams ^ realisation);
  const double sweeping = spectrum.sweeping_speed();
  const Eigen::Matrix3d& stretch = spectrum.options().stretch;
  for (int m = 0; m < modes; ++m) {
    const ModeSpectrum::Stratum stratum = spectrum.at_share((m + random.uniform()) / modes);
    const Eigen::Vector3d direction = isotropic_direction(random);
    const double deviation = (mirrored ? -1.0 : 1.0) * std::sqrt(stratum.energy);
    const Eigen::Vector3d a = deviation * stretch * normal_across(random, direction);
    const Eigen::Vector3d b = deviation * stretch * normal_across(random, direction);
    const double frequency = sweeping * stratum.wave_number * random.normal();
    const auto put = [&](std::size_t row, double value) {
      rows_[row * count_ + static_cast<std::size_t>(m)] = value;
    };
    for (int i = 0; i < 3; ++i) {
      const auto row = static_cast<std::size_t>(i);
      put(row, stratum.wave_number * direction[i]);
      put(4 + row, a[i]);
      put(7 + row, b[i]);
    }
    put(3, frequency);
  }
}

AmbientSample WindModes::sample(double t, const Eigen::Vector3d& position) const {
  const Eigen::Vector3d place = position - t * convection_;
  ModeSum sum;
  sum_modes({.numbers = rows_.data(), .count = count_}, place.data(), t, sum);
  return sample_of(sum, convection_);
}

AmbientSample WindModes::mean_over(const Ellipse& ellipse, double t, const Eigen::Vector3d& position) const {
  const Eigen::Vector3d place = position - t * convection_;
  ModeSum sum;
  sum_modes_over_ellipse({.numbers = rows_.data(), .count = count_}, place.data(), t, ellipse.first.data(),
                         ellipse.second.data(), sum);
  return sample_of(sum, convection_);
}

}  // namespace samara::models::wind
