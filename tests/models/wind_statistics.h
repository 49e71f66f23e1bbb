#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <Eigen/Core>

#include "samara/base/streams.h"

/// Spectra along a line, for tests of winds.
namespace samara::models::wind {

struct LineSpectra {
  double longitudinal = 0.0, transverse = 0.0;  ///< sums over the band, the latter of two components
  double variance = 0.0;
  double transverse_over_longitudinal() const { return 0.5 * transverse / longitudinal; }
};

/// From values at `places` places along x, with a window of Hann against what leaks from low wave numbers.
/// @param field (realisation) -> (x) -> velocity
template <class Field>
LineSpectra line_spectra(int realisations, double spacing, int places, double lowest, double highest,
                         const Field& field) {
  using std::numbers::pi;
  LineSpectra sums;
  Eigen::MatrixXd values(3, places);
  for (int r = 0; r < realisations; ++r) {
    const auto flow = field(r);
    for (int i = 0; i < places; ++i) values.col(i) = flow(i * spacing);
    sums.variance += values.squaredNorm() / (3.0 * places * realisations);
    for (int i = 0; i < places; ++i) values.col(i) *= std::pow(std::sin(pi * i / places), 2);
    const double line = 2.0 * pi / (places * spacing);
    const int first = static_cast<int>(lowest / line), last = static_cast<int>(highest / line);
    for (int m = first; m <= last; m += 2) {  // neighbours are not independent under the window
      Eigen::Vector3d cosine = Eigen::Vector3d::Zero(), sine = Eigen::Vector3d::Zero();
      for (int i = 0; i < places; ++i) {
        const double phase = 2.0 * pi * static_cast<double>((static_cast<long>(m) * i) % places) / places;
        cosine += std::cos(phase) * values.col(i);
        sine += std::sin(phase) * values.col(i);
      }
      const Eigen::Vector3d power = cosine.cwiseAbs2() + sine.cwiseAbs2();
      sums.longitudinal += power.x();
      sums.transverse += power.y() + power.z();
    }
  }
  return sums;
}

/// A toy: white noise through a low-pass in each component, of the right variance and length.
class FilteredNoise {
 public:
  FilteredNoise(double sigma, double length, double spacing, int places, int number) : spacing_(spacing) {
    Stream random(17, static_cast<std::uint64_t>(number));
    const double kept = std::exp(-spacing / length);
    Eigen::Vector3d value;
    for (double& x : value) x = sigma * random.normal();
    for (int i = 0; i < places; ++i) {
      values_.push_back(value);
      for (double& x : value) x = kept * x + std::sqrt(1.0 - kept * kept) * sigma * random.normal();
    }
  }
  Eigen::Vector3d operator()(double x) const {
    return values_[static_cast<std::size_t>(std::lround(x / spacing_))];
  }

 private:
  double spacing_;
  std::vector<Eigen::Vector3d> values_;
};

}  // namespace samara::models::wind
