#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "samara/models/wind/wind_profile.h"
#include "samara/models/wind/wind_spectrum.h"

/// Series of turbulent wind at points, as wind turbines are designed with: the spectrum of every component at every
/// point, and the coherence of every pair, are given; the components are independent of each other, and nothing makes
/// the field between the points free of divergence. For bodies that fly through a field take wind_modes.h.
///
/// For each frequency the matrix of coherences (wind_spectrum.h, with height and speed in the middle of the points) is
/// factorised, and mixes independent normal amplitudes, one for each point; points further along the wind get the same
/// later, as if eddies were carried at the mean speed. The inverse Fourier transform makes series of them: normal, and
/// periodic in their duration. P. S. Veers, Three-dimensional wind simulation, SAND88-0152 (1988).
namespace samara::models::wind {

enum class SeriesSpectrum {
  iec,     ///< iec_spectrum
  kaimal,  ///< kaimal_spectrum, from the friction velocity of a logarithmic profile
};

/// A series holds 3 numbers a sample and point.
constexpr double kMostSeriesNumbers = 2e7;

struct SeriesOptions {
  SeriesSpectrum spectrum = SeriesSpectrum::iec;
  double sigma = 0.0;  ///< deviation along the wind [m/s]; `iec` only
  double step = 0.05;  ///< [s]
  long samples = 0;
  /// Columns: along the wind, across it to the left, up from the ground [m].
  Eigen::Matrix3Xd points = {};
};

struct WindSeries {
  Eigen::VectorXd times;  ///< from 0 [s]
  /// Along, across, vertical: (samples x points), the mean included [m/s].
  Eigen::MatrixXd velocity[3];
};

/// S [m^2/s] of a component at the height of a point.
double series_spectrum(const WindProfile& profile, const SeriesOptions& options, Component component,
                       double n, double z);

/// Height and mean speed that the coherences are taken with.
struct CoherenceReference {
  double height = 0.0;  ///< of the middle of the points [m]
  double speed = 0.0;   ///< [m/s]
};
CoherenceReference coherence_reference(const WindProfile& profile, const Eigen::Matrix3Xd& points);

/// The same bits for the same seed and number.
/// @throws ArgumentError unless there are points, all where the mean wind blows, at least 4 samples, at most 1000
/// points and 2e7 numbers in all, no prime factor of the samples above 1000; step and, for `iec`, sigma positive and
/// finite; for `kaimal` a logarithmic profile.
WindSeries wind_series(const WindProfile& profile, const SeriesOptions& options, std::uint64_t seed,
                       std::uint64_t realisation = 0);

/// What a series came out as, beside what it was drawn from.
struct SeriesStatistics {
  Eigen::Matrix3Xd mean;       ///< component x point [m/s]
  Eigen::Matrix3Xd deviation;  ///< [m/s]
  Eigen::Matrix3Xd target;  ///< deviation of the sum of the spectrum over the frequencies of the series [m/s]
};
SeriesStatistics statistics_of(const WindSeries& series, const WindProfile& profile,
                               const SeriesOptions& options);

}  // namespace samara::models::wind
