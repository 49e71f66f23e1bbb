#pragma once

/// Spectra of wind: over frequency at a fixed point (Kaimal's, the standard's), over wave number in
/// isotropic turbulence (von Karman's).
///
/// Frequencies n are in Hz, wave numbers k in rad/m. All spectra are one-sided: their integral from 0 to infinity is
/// the variance. Components: along the mean wind (u), across it (v), vertical (w).
///
/// Sources: Kaimal et al. (1972), see wind_profile.h; IEC 61400-1 ed. 3 (2005), annex B.2 and its tables; T. von
/// Karman, Progress in the statistical theory of turbulence, PNAS 34 (1948), with a constant of 1.7 as J. Mann, Wind
/// field simulation, Prob. Eng. Mech. 13 (1998) uses it.
namespace samara::models::wind {

enum class Component { along, across, vertical };

/// n S/u_star^2 = 105 f/(1 + 33 f)^(5/3), 17 f/(1 + 9.5 f)^(5/3), 2.1 f/(1 + 5.3 f^(5/3)) with f = n z/U: the neutral
/// surface layer. @returns S [m^2/s]
double kaimal_spectrum(Component component, double n, double z, double speed, double friction_velocity);
/// Its integral, over u_star^2: 4.77, 2.68, 1.53.
double kaimal_variance(Component component);

/// The length Lambda of IEC 61400-1 [m]: 0.7 z up to z = 60 m, 42 m above.
double iec_scale(double z);
/// Deviation of a component over that along the wind: 1, 0.8, 0.5.
double iec_deviation_ratio(Component component);
/// Length of a component over Lambda: 8.1, 2.7, 0.66.
double iec_length_ratio(Component component);
/// n S/sigma^2 = 4 n L/U/(1 + 6 n L/U)^(5/3). @param sigma_along deviation along the wind [m/s]
/// @returns S [m^2/s]
double iec_spectrum(Component component, double n, double z, double speed, double sigma_along);

/// Coherence of a component at two points `distance` apart across the wind: along the wind that of IEC 61400-1,
/// exp(-12 sqrt((n r/U)^2 + (0.12 r/L_c)^2)) with L_c = 8.1 Lambda; across and vertical Davenport's, exp(-7 n r/U),
/// since the standard gives none.
double wind_coherence(Component component, double n, double distance, double z, double speed);

/// Isotropic turbulence: E(k) = alpha eps^(2/3) L^(5/3) (L k)^4/(1 + (L k)^2)^(17/6).
class VonKarmanSpectrum {
 public:
  static constexpr double kAlpha = 1.7;

  /// @param sigma deviation of every component [m/s]
  /// @param length L [m]
  /// @throws ArgumentError unless both are positive and finite.
  VonKarmanSpectrum(double sigma, double length);
  /// sigma^2 = 2 k/3, and L = 0.430 k^(3/2)/eps, with which the inertial range holds at alpha = 1.7.
  static VonKarmanSpectrum of_energy(double k, double eps);

  double sigma() const { return sigma_; }
  double length() const { return length_; }
  /// eps [m^2/s^3]
  double dissipation() const;
  /// The integral length along a component, 0.7468 L [m].
  double integral_length() const;

  /// E(k) [m^3/s^2]: the integral is 3/2 sigma^2.
  double energy(double k) const;
  /// Spectrum of a component over the wave number along itself [m^3/s^2].
  double longitudinal(double k) const;
  /// Spectrum of a component over a wave number across itself: 4/3 of the longitudinal at high wave numbers.
  double transverse(double k) const;
  /// D_LL(r) = <(u(x + r) - u(x))^2> of the component along r [m^2/s^2].
  double structure_function(double r) const;

  /// What a band of wave numbers holds of the variance, between 0 and 1.
  double variance_share(double lowest, double highest) const;
  /// D_LL(r) of the band alone [m^2/s^2].
  double structure_function(double r, double lowest, double highest) const;

 private:
  double sigma_, length_;
};

}  // namespace samara::models::wind
