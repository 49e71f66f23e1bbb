#include "samara/models/wind/wind_spectrum.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/models/wind/wind_profile.h"

using namespace samara::models::wind;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr Component kComponents[] = {Component::along, Component::across, Component::vertical};

/// The integral of f from 0 to infinity by the trapezoidal rule in ln x, which is good to round-off for what decays at
/// both ends of it.
template <class F>
double integral_to_infinity(double lowest, double highest, const F& f) {
  constexpr int kNodes = 20000;
  const double h = std::log(highest / lowest) / kNodes;
  double sum = 0.0;
  for (int i = 0; i <= kNodes; ++i) {
    const double x = lowest * std::exp(i * h);
    sum += (i == 0 || i == kNodes ? 0.5 : 1.0) * f(x) * x * h;
  }
  return sum;
}

}  // namespace

TEST_CASE("the wind over hedged farmland follows the logarithm of height, and is still below the roughness") {
  const WindProfile profile({.speed = 5.0, .height = 10.0, .roughness = 0.3});
  CHECK_THAT(profile.speed(10.0) / profile.friction_velocity(), WithinRel(8.766394743299953, 1e-14));
  CHECK_THAT(profile.speed(10.0), WithinRel(5.0, 1e-15));
  CHECK(profile.speed(0.3) == 0.0);
  CHECK(profile.speed(0.1) == 0.0);
  CHECK(profile.speed(0.0) == 0.0);
  CHECK(profile.speed(-3.0) == 0.0);
  const WindProfile canopy({.speed = 5.0, .height = 30.0, .roughness = 1.0, .displacement = 12.0});
  CHECK(canopy.speed(13.0) == 0.0);
  CHECK_THAT(canopy.speed(30.0), WithinRel(5.0, 1e-15));
}

TEST_CASE("the shear of every profile is the slope of its speed") {
  const WindProfile profiles[] = {
      WindProfile({.kind = ProfileKind::uniform, .speed = 3.0}),
      WindProfile({.speed = 5.0, .height = 10.0, .roughness = 0.3, .displacement = 1.0}),
      WindProfile({.kind = ProfileKind::power, .speed = 5.0, .height = 10.0, .exponent = 0.2})};
  for (const WindProfile& profile : profiles) {
    for (const double z : {-1.0, 0.004, 0.5, 2.0, 7.0, 40.0}) {
      const double h = 1e-6 * std::abs(z);
      CHECK_THAT((profile.speed(z + h) - profile.speed(z - h)) / (2.0 * h),
                 WithinAbs(profile.shear(z), 1e-6));
    }
  }
  // A line below a thousandth of the height joins the power law without a jump.
  CHECK_THAT(profiles[2].speed(0.01 * (1.0 + 1e-12)),
             WithinRel(profiles[2].speed(0.01 * (1.0 - 1e-12)), 1e-9));
}

TEST_CASE("the integrals of Kaimal's spectra and their inertial ranges are those of their closed forms") {
  const double variances[] = {4.7727, 2.6842, 1.5302};
  const double inertial[] = {0.3093, 0.3989, 0.3962};
  const double z = 20.0, U = 7.0, u_star = 0.4;
  for (int c = 0; c < 3; ++c) {
    const auto S = [&](double n) { return kaimal_spectrum(kComponents[c], n, z, U, u_star); };
    // Beyond the ends: S(0) 1e-12 Hz, and 3/2 n S.
    const double end = 1e9;
    const double integral = integral_to_infinity(1e-12, end, S) + 1.5 * end * S(end);
    CHECK_THAT(integral / (u_star * u_star), WithinAbs(kaimal_variance(kComponents[c]), 1e-6));
    CHECK_THAT(kaimal_variance(kComponents[c]), WithinAbs(variances[c], 1e-4));
    const double n = 1e9;
    const double f = n * z / U;
    CHECK_THAT(n * S(n) / (u_star * u_star) * std::pow(f, 2.0 / 3.0), WithinAbs(inertial[c], 1e-4));
  }
}

TEST_CASE("the integrals of the standard's spectra are its variances") {
  for (const Component component : kComponents) {
    const double end = 1e6;
    const auto S = [&](double n) { return iec_spectrum(component, n, 30.0, 10.0, 1.5); };
    const double variance = std::pow(1.5 * iec_deviation_ratio(component), 2);
    CHECK_THAT(integral_to_infinity(1e-12, end, S) + 1.5 * end * S(end), WithinRel(variance, 1e-6));
  }
  CHECK(iec_scale(30.0) == 21.0);
  CHECK(iec_scale(80.0) == 42.0);
}

TEST_CASE("coherence is one at one place and falls with distance and frequency as the standard says") {
  CHECK(wind_coherence(Component::along, 0.1, 0.0, 30.0, 10.0) == 1.0);
  // exp(-12 hypot(n r/U, 0.12 r/170.1 m)), by hand.
  CHECK_THAT(wind_coherence(Component::along, 0.02, 5.0, 30.0, 10.0), WithinAbs(0.88052, 1e-5));
  CHECK_THAT(wind_coherence(Component::along, 0.1, 5.0, 30.0, 10.0), WithinAbs(0.54799, 1e-5));
  CHECK_THAT(wind_coherence(Component::along, 0.02, 15.0, 30.0, 10.0), WithinAbs(0.68267, 1e-5));
  CHECK_THAT(wind_coherence(Component::along, 0.1, 15.0, 30.0, 10.0), WithinAbs(0.16456, 1e-5));
  CHECK_THAT(wind_coherence(Component::vertical, 0.1, 5.0, 30.0, 10.0), WithinRel(std::exp(-0.35), 1e-14));
}

TEST_CASE("von Karman's turbulence has its integral length, dissipation and inertial range") {
  const VonKarmanSpectrum spectrum(1.2, 10.0);
  CHECK_THAT(spectrum.integral_length() / 10.0, WithinRel(0.746834, 1e-5));
  const double inertial = std::pow(spectrum.dissipation() * 10.0, 2.0 / 3.0);
  CHECK_THAT(1.44 / (1.7 * inertial), WithinRel(0.688344, 1e-5));
  const double r = 1e-5;
  CHECK_THAT(spectrum.structure_function(r) / std::pow(spectrum.dissipation() * r, 2.0 / 3.0),
             WithinRel(2.2357, 1e-5));
  CHECK_THAT(VonKarmanSpectrum::of_energy(2.0, 0.5).length(),
             WithinRel(0.4300 * std::pow(2.0, 1.5) / 0.5, 1e-4));
  CHECK_THAT(VonKarmanSpectrum::of_energy(2.0, 0.5).dissipation(), WithinRel(0.5, 1e-13));
}

TEST_CASE(
    "the one-dimensional spectra, the energy and the structure function of von Karman are one turbulence") {
  const VonKarmanSpectrum spectrum(1.2, 10.0);
  const auto longitudinal = [&](double k) { return spectrum.longitudinal(k); };
  const double end = 1e9;
  CHECK_THAT(integral_to_infinity(1e-12, end, longitudinal) + 1.5 * end * longitudinal(end),
             WithinRel(1.44, 1e-6));
  CHECK_THAT(integral_to_infinity(1e-12, end, [&](double k) { return spectrum.transverse(k); }) +
                 1.5 * end * spectrum.transverse(end),
             WithinRel(1.44, 1e-6));
  CHECK_THAT(spectrum.transverse(1e6) / spectrum.longitudinal(1e6), WithinRel(4.0 / 3.0, 1e-6));
  // F(k1) is the integral of E/k (1 - k1^2/k^2) over k > k1.
  const double k1 = 0.3;
  const double from_energy = integral_to_infinity(
      k1, 1e7, [&](double k) { return spectrum.energy(k) / k * (1.0 - k1 * k1 / (k * k)); });
  CHECK_THAT(from_energy, WithinRel(spectrum.longitudinal(k1), 1e-6));
  // Above 1e6/L lie 1.5e-4 of the variance, which are 3.6e-4 of this D.
  CHECK_THAT(spectrum.structure_function(3.0, 1e-6, 1e5), WithinRel(spectrum.structure_function(3.0), 5e-4));
  CHECK_THAT(integral_to_infinity(0.02, 20.0, [&](double k) { return spectrum.energy(k); }) / (1.5 * 1.44),
             WithinRel(spectrum.variance_share(0.02, 20.0), 1e-6));
  CHECK_THAT(spectrum.variance_share(0.002, 20.0), WithinAbs(0.9575, 1e-4));
}

TEST_CASE(
    "the surface layer has Kaimal's energy, or that of the k-epsilon model, and the dissipation of its "
    "shear") {
  const samara::models::Turbulence kaimal = surface_layer_turbulence(0.5, 8.0);
  CHECK_THAT(kaimal.k, WithinAbs(4.4936 * 0.25, 1e-4));
  CHECK_THAT(kaimal.epsilon, WithinRel(0.125 / (0.4 * 8.0), 1e-14));
  CHECK_THAT(surface_layer_turbulence(0.5, 8.0, EnergyConstants::k_epsilon).k, WithinRel(0.25 / 0.3, 1e-14));
  const WindProfile profile({.speed = 4.0, .height = 10.0, .roughness = 0.05});
  const auto layer = surface_layer(profile, 0.5 * std::numbers::pi);
  const Eigen::Vector3d place(3.0, 4.0, 2.5);
  CHECK_THAT(layer->sample(0.0, place).velocity.y(), WithinRel(profile.speed(2.5), 1e-14));
  CHECK_THAT(layer->sample(0.0, place).gradient(1, 2), WithinRel(profile.shear(2.5), 1e-14));
  const double u_star = profile.friction_velocity();
  CHECK_THAT(layer->turbulence(0.0, place).epsilon, WithinRel(u_star * u_star * u_star / (0.4 * 2.5), 1e-13));
  // Production and dissipation balance.
  CHECK_THAT(u_star * u_star * profile.shear(2.5), WithinRel(layer->turbulence(0.0, place).epsilon, 1e-13));
  CHECK(layer->turbulence(0.0, {0.0, 0.0, 0.01}).epsilon == layer->turbulence(0.0, {0.0, 0.0, 0.05}).epsilon);
  // A body lands when it has crossed the ground: the flow goes on there.
  CHECK(layer->turbulence(0.0, {0.0, 0.0, -0.01}).inside);
}

TEST_CASE("the speed of a wind is no number where the height is none") {
  for (const ProfileKind kind : {ProfileKind::logarithmic, ProfileKind::power})
    CHECK(std::isnan(WindProfile({.kind = kind, .speed = 5.0, .height = 10.0, .roughness = 0.3}).speed(NAN)));
}

TEST_CASE("a wind profile that cannot be is refused with what is wrong") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(
      WindProfile({.speed = 5.0, .height = 0.2, .roughness = 0.3}),
      "the height of the mean speed is 0.2 m; more than 0.3 m, displacement and roughness, was expected");
  CHECK_THROWS_WITH(WindProfile({.speed = 5.0, .roughness = 0.0}),
                    "the roughness of the ground [m] is 0; a positive finite number was expected");
  CHECK_THROWS_AS(WindProfile({.speed = 5.0, .roughness = -0.1}), samara::ArgumentError);
  CHECK_THROWS_AS(WindProfile({.speed = -5.0}), samara::ArgumentError);
  CHECK_THROWS_AS(WindProfile({.speed = nan}), samara::ArgumentError);
  CHECK_THROWS_AS(WindProfile({.speed = 5.0, .height = nan}), samara::ArgumentError);
  CHECK_THROWS_AS(WindProfile({.speed = 5.0, .displacement = nan}), samara::ArgumentError);
  CHECK_THROWS_AS(WindProfile({.kind = ProfileKind::power, .speed = 5.0, .exponent = 0.0}),
                  samara::ArgumentError);
  CHECK_THROWS_AS(VonKarmanSpectrum(0.0, 1.0), samara::ArgumentError);
  CHECK_THROWS_AS(VonKarmanSpectrum(1.0, nan), samara::ArgumentError);
  CHECK_THROWS_WITH(WindProfile({.kind = ProfileKind::power, .speed = 5.0}).friction_velocity(),
                    "only a logarithmic wind profile has a friction velocity");
  CHECK_THROWS_AS(surface_layer(WindProfile({.speed = 0.0})), samara::ArgumentError);
  CHECK_THROWS_AS(surface_layer(WindProfile({.speed = 1.0}), nan), samara::ArgumentError);
}
