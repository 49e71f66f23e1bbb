#include <cmath>
#include <numbers>
#include <utility>

#include "samara/models/fields/field_model.h"

// c du/dt = k d2u/dx2 on 0 < x < l, u(t,0) = g0, u(t,l) = g1, u(0,x) = g0 + (g1 - g0) s + 4 a s (1 - s) with s = x/l:
// a rod that an electric current had warmed, at the moment when it is switched off.

namespace samara::models {

namespace {

// Places in the list of parameters.
enum Parameter { kConductivity, kCapacity, kLength, kLeft, kRight, kAmplitude };

/// 4 i2erfc(z), the twice repeated integral of the complementary error function, one at z = 0.
double four_i2erfc(double z) {
  if (z > 6.5) return 0.0;  // below 1e-18; further out z^2 overflows
  return (1.0 + 2.0 * z * z) * std::erfc(z) - 2.0 / std::sqrt(std::numbers::pi) * z * std::exp(-z * z);
}

/// What is left at the dimensionless time tau of 4 s (1 - s) between ends at zero, for tau up to 0.1: within, the
/// parabola sinks by 8 tau; what its ends, which stay, send inwards, is reflected there.
double early_parabola(double tau, double s) {
  double value = 4.0 * s * (1.0 - s) - 8.0 * tau;
  if (tau == 0.0) return value;
  const double width = 2.0 * std::sqrt(tau);
  for (int n = 0; n < 6; ++n) {
    const double sign = n % 2 == 0 ? 8.0 : -8.0;
    value += sign * tau * (four_i2erfc((n + s) / width) + four_i2erfc((n + 1.0 - s) / width));
  }
  return value;
}

/// The same by sines, for tau from 0.1 on. Terms end where their decay is below 1e-19.
double late_parabola(double tau, double s) {
  constexpr double pi = std::numbers::pi;
  constexpr double kNothing = 44.0;
  const double step = 2.0 * std::cos(2.0 * pi * s);
  double sine = std::sin(pi * s), sine_before = -sine;
  double value = 0.0;
  for (int n = 1; n <= 9; n += 2) {
    const double decay = n * n * pi * pi * tau;
    if (decay > kNothing) break;
    value += 32.0 / (n * n * n * pi * pi * pi) * sine * std::exp(-decay);
    sine_before = std::exchange(sine, step * sine - sine_before);  // of (n + 2) pi s
  }
  return value;
}

double temperature(double t, double x, std::span<const double> p) {
  constexpr double kLate = 0.1;  // the first term left out on either side is below 1e-17
  const double s = x / p[kLength];
  const double tau = p[kConductivity] * t / (p[kCapacity] * p[kLength] * p[kLength]);
  const double parabola = tau < kLate ? early_parabola(tau, s) : late_parabola(tau, s);
  return p[kLeft] + (p[kRight] - p[kLeft]) * s + p[kAmplitude] * parabola;
}

FieldModel make_heat_rod() {
  FieldModel field;
  field.info = {
      .name = "heat_rod",
      .title = "heat conduction in a rod between two temperatures",
      .equations =
          "capacity du/dt = conductivity d2u/dx2,  u(t,0) = left,  u(t,length) = right,  u(0,x) = "
          "left + (right - left) x/length + 4 amplitude x/length (1 - x/length)",
      .frames = "x runs along the rod from its left end; temperatures are differences from any reference",
      .source =
          "H. S. Carslaw, J. C. Jaeger, Conduction of Heat in Solids, 2nd ed., Oxford 1959, chapter III; the "
          "initial profile is the steady one of a rod heated evenly by a current",
      .validity = "material constants that do not depend on temperature; no loss through the side",
      .states = {{"u", "K", 0.0, "temperature"}},
      .parameters = {
          {"conductivity", "W/(m K)", {}, "", "of heat", 0.0},
          {"capacity", "J/(m^3 K)", {}, "", "heat capacity of the volume: density times specific heat", 0.0},
          {"length", "m", {}, "", "of the rod; always fixed", 0.0},
          {"left", "K", 0.0, "", "temperature at x = 0"},
          {"right", "K", 0.0, "", "temperature at x = length"},
          {"amplitude", "K", 0.0, "", "how far the middle begins above the mean of both ends"}}};
  field.place = "x";
  field.extent = "length";
  field.linear_in = {"left", "right", "amplitude"};
  field.exact = &temperature;
  field.exact_source = "the exact solution, by images and by sines (Carslaw and Jaeger, chapter III)";
  return field;
}

}  // namespace

const FieldModel& heat_rod() {
  static const FieldModel field = make_heat_rod();
  return field;
}

}  // namespace samara::models
