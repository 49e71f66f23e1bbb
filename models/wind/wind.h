#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "samara/models/stochastic/air_along_path.h"
#include "samara/models/wind/gust.h"
#include "samara/models/wind/wind_modes.h"
#include "samara/models/wind/wind_profile.h"

/// A wind as a whole: mean profile, turbulence, gusts.
///
///   Wind wind{.profile = WindProfile({.speed = 4.0, .roughness = 0.03})};
///   wind.turbulence = TurbulenceOptions{};
///   const auto model = immersed_body_in(wind_flow(wind, 0.08, seed, realisation));
namespace samara::models::wind {

/// Turbulence as a field of modes. What is not given follows from the neutral surface layer at `height`.
struct TurbulenceOptions {
  /// Where energy and length are taken, and the speed with which eddies are carried [m]. Empty: that of the mean speed.
  std::optional<double> height = {};
  std::optional<double> sigma = {};   ///< deviation of every component [m/s]
  std::optional<double> length = {};  ///< L of von Karman's spectrum [m]
  EnergyConstants constants = EnergyConstants::kaimal;
  /// Deviations along the wind, across it and vertical over sigma, IEC 61400-1 has (1, 0.8, 0.5): other than equal they
  /// leave a divergence (ModeSpectrum::divergence()).
  Eigen::Vector3d ratios = Eigen::Vector3d::Ones();
  int modes = 200;
  /// Shortest and longest wave [m]; empty: the length of the body, and 2 pi L/0.02.
  std::optional<double> shortest = {}, longest = {};
  bool frozen = false;
};

struct Wind {
  WindProfile profile;
  double towards = 0.0;  ///< where it blows [rad], from x to y
  std::optional<TurbulenceOptions> turbulence = {};
  std::vector<Gust> gusts = {};

  /// Unit vector.
  Eigen::Vector3d direction() const;
};

/// The modes of the turbulence that a body meets. Has `turbulence`.
/// @param body_length of the body [m], used where `shortest` is not given
/// @throws ArgumentError where sigma or length do not follow from the profile (it is not logarithmic, or there is no
/// wind), or a number makes no turbulence.
ModeSpectrum mode_spectrum(const Wind& wind, double body_length);

/// One realisation as a flow: mean wind, modes, gusts. Without turbulence all realisations are one.
std::shared_ptr<const AmbientFlow> wind_flow(const Wind& wind, double body_length, std::uint64_t seed,
                                             std::uint64_t realisation);

/// All realisations, for clouds of bodies (realisations.h). Number i is wind_flow() of i, with every mode averaged over
/// the outline of the body in its attitude.
/// @param semi_axes of the flat body along its axes x and y [m]; zero: no average
std::shared_ptr<const AirSource> wind_air(const Wind& wind, double body_length,
                                          const Eigen::Vector2d& semi_axes, std::uint64_t seed);

}  // namespace samara::models::wind
