#include "samara/models/wind/wind_spectrum.h"

#include <cmath>
#include <numbers>

#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <boost/math/special_functions/gamma.hpp>

#include "samara/base/require.h"

namespace samara::models::wind {

namespace {

using std::numbers::pi;

/// The integral of f(x) d ln x from lowest to highest, by Simpson's rule in ln x.
template <class F>
double log_integral(double lowest, double highest, int intervals, const F& f) {
  const double start = std::log(lowest);
  const double h = (std::log(highest) - start) / intervals;
  double sum = 0.0;
  for (int i = 0; i <= intervals; ++i) {
    const double weight = i == 0 || i == intervals ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    sum += weight * f(std::exp(start + i * h));
  }
  return sum * h / 3.0;
}

/// The integral of x^4/(1 + x^2)^(17/6) from 0 to infinity.
double karman_integral() {
  static const double value = 0.5 * boost::math::beta(2.5, 1.0 / 3.0);
  return value;
}

/// (sin x - x cos x)/x^3
double transfer(double x) {
  if (x < 0.05) return 1.0 / 3.0 - x * x / 30.0 + x * x * x * x / 840.0;
  return (std::sin(x) - x * std::cos(x)) / (x * x * x);
}

}  // namespace

double kaimal_spectrum(Component component, double n, double z, double speed, double friction_velocity) {
  const double per_hertz = z / speed;
  const double f = n * per_hertz;
  const double scale = friction_velocity * friction_velocity * per_hertz;
  switch (component) {
    case Component::along:
      return scale * 105.0 / std::pow(1.0 + 33.0 * f, 5.0 / 3.0);
    case Component::across:
      return scale * 17.0 / std::pow(1.0 + 9.5 * f, 5.0 / 3.0);
    case Component::vertical:
      break;
  }
  return scale * 2.1 / (1.0 + 5.3 * std::pow(f, 5.0 / 3.0));
}

double kaimal_variance(Component component) {
  switch (component) {
    case Component::along:
      return 1.5 * 105.0 / 33.0;
    case Component::across:
      return 1.5 * 17.0 / 9.5;
    case Component::vertical:
      break;
  }
  // The integral of 1/(1 + c f^p) is c^(-1/p) (pi/p)/sin(pi/p).
  return 2.1 * std::pow(5.3, -0.6) * 0.6 * pi / std::sin(0.6 * pi);
}

double iec_scale(double z) {
  return z < 60.0 ? 0.7 * z : 42.0;
}

double iec_deviation_ratio(Component component) {
  switch (component) {
    case Component::along:
      return 1.0;
    case Component::across:
      return 0.8;
    case Component::vertical:
      break;
  }
  return 0.5;
}

double iec_length_ratio(Component component) {
  switch (component) {
    case Component::along:
      return 8.1;
    case Component::across:
      return 2.7;
    case Component::vertical:
      break;
  }
  return 0.66;
}

double iec_spectrum(Component component, double n, double z, double speed, double sigma_along) {
  const double sigma = sigma_along * iec_deviation_ratio(component);
  const double travel = iec_length_ratio(component) * iec_scale(z) / speed;
  return 4.0 * sigma * sigma * travel / std::pow(1.0 + 6.0 * n * travel, 5.0 / 3.0);
}

double wind_coherence(Component component, double n, double distance, double z, double speed) {
  const double reduced = n * distance / speed;
  if (component != Component::along) return std::exp(-7.0 * reduced);
  const double length = iec_length_ratio(Component::along) * iec_scale(z);
  return std::exp(-12.0 * std::hypot(reduced, 0.12 * distance / length));
}

VonKarmanSpectrum::VonKarmanSpectrum(double sigma, double length) : sigma_(sigma), length_(length) {
  require_positive(sigma, "the deviation of the turbulence [m/s]");
  require_positive(length, "the length of the turbulence [m]");
}

VonKarmanSpectrum VonKarmanSpectrum::of_energy(double k, double eps) {
  require_positive(k, "the turbulent energy k [m^2/s^2]");
  require_positive(eps, "the dissipation eps [m^2/s^3]");
  // k = alpha (eps L)^(2/3) times the integral.
  return {std::sqrt(2.0 / 3.0 * k), std::pow(k / (kAlpha * karman_integral()), 1.5) / eps};
}

double VonKarmanSpectrum::dissipation() const {
  return std::pow(1.5 * sigma_ * sigma_ / (kAlpha * karman_integral()), 1.5) / length_;
}

double VonKarmanSpectrum::integral_length() const {
  return 0.5 * pi * longitudinal(0.0) / (sigma_ * sigma_);
}

double VonKarmanSpectrum::energy(double k) const {
  const double x2 = k * k * length_ * length_;
  return 1.5 * sigma_ * sigma_ * length_ / karman_integral() * x2 * x2 * std::pow(1.0 + x2, -17.0 / 6.0);
}

double VonKarmanSpectrum::longitudinal(double k) const {
  const double x2 = k * k * length_ * length_;
  return 1.5 * sigma_ * sigma_ * length_ / karman_integral() * (18.0 / 55.0) * std::pow(1.0 + x2, -5.0 / 6.0);
}

double VonKarmanSpectrum::transverse(double k) const {
  // (F - k F')/2 of the longitudinal F.
  const double x2 = k * k * length_ * length_;
  return 0.5 * longitudinal(k) * (1.0 + 8.0 / 3.0 * x2) / (1.0 + x2);
}

double VonKarmanSpectrum::structure_function(double r) const {
  const double x = r / length_;
  if (x == 0.0) return 0.0;
  constexpr double third = 1.0 / 3.0;
  const double correlation = std::pow(2.0, 2.0 * third) / boost::math::tgamma(third) * std::pow(x, third) *
                             boost::math::cyl_bessel_k(third, x);
  return 2.0 * sigma_ * sigma_ * (1.0 - correlation);
}

double VonKarmanSpectrum::variance_share(double lowest, double highest) const {
  const auto above = [&](double k) {
    const double x2 = k * k * length_ * length_;
    // The share above by its own function: it is small where the spectrum ends.
    return boost::math::ibetac(2.5, 1.0 / 3.0, x2 / (1.0 + x2));
  };
  return above(lowest) - above(highest);
}

double VonKarmanSpectrum::structure_function(double r, double lowest, double highest) const {
  // 4 E (1/3 - transfer) dk; where k r turns fast between nodes its part is below (k r)^-2.
  return log_integral(lowest, highest, 8192,
                      [&](double k) { return 4.0 * k * energy(k) * (1.0 / 3.0 - transfer(k * r)); });
}

}  // namespace samara::models::wind
