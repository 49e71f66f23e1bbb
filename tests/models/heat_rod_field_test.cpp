// The exact solution of the rod: what the equation, its ends and its beginning say, and what two forms agree on.
#include <cmath>
#include <numbers>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/models/fields/field_model.h"

using Catch::Matchers::WithinAbs;
using samara::models::heat_rod;

namespace {

/// k = 2, c = 5, l = 3, ends at 1 and -2, amplitude 4.
const std::vector<double> kRod = {2.0, 5.0, 3.0, 1.0, -2.0, 4.0};

double u(double t, double x) {
  return heat_rod().exact(t, x, kRod);
}

/// The time at which the dimensionless one, k t/(c l^2), is tau.
double at_tau(double tau) {
  return tau * 5.0 * 9.0 / 2.0;
}

/// 4 s (1 - s) by sines alone, which converge as n^-3 at the beginning and much faster later on.
double by_sines(double tau, double s) {
  constexpr double pi = std::numbers::pi;
  double value = 0.0;
  for (int n = 1; n < 4000; n += 2)
    value += 32.0 / std::pow(n * pi, 3) * std::sin(n * pi * s) * std::exp(-n * n * pi * pi * tau);
  return value;
}

}  // namespace

TEST_CASE("the rod begins with its parabola and keeps its ends") {
  for (const double s : {0.0, 0.1, 0.5, 0.77, 1.0})
    CHECK_THAT(u(0.0, 3.0 * s), WithinAbs(1.0 - 3.0 * s + 16.0 * s * (1.0 - s), 1e-13));
  // The smallest time that there is, too.
  for (const double s : {0.1, 0.5, 0.77})
    CHECK_THAT(u(1e-320, 3.0 * s), WithinAbs(1.0 - 3.0 * s + 16.0 * s * (1.0 - s), 1e-13));
  for (const double t : {1e-6, 1e-3, 0.3, 2.0, 100.0}) {
    CHECK_THAT(u(t, 0.0), WithinAbs(1.0, 1e-13));
    CHECK_THAT(u(t, 3.0), WithinAbs(-2.0, 1e-13));
  }
}

TEST_CASE("the exact field of the rod is the series of sines, before and after the change of form") {
  // The terms left out at n = 4000 sum to 16/(pi^3 n^2) = 3e-8 at tau = 0; at 1e-5, exp(-n^2 pi^2 tau) has ended them.
  for (const double tau : {1e-5, 1e-3, 0.01, 0.0999999, 0.1, 0.1000001, 0.3, 1.0}) {
    for (const double s : {0.003, 0.1, 0.5, 0.9})
      CHECK_THAT(u(at_tau(tau), 3.0 * s), WithinAbs(1.0 - 3.0 * s + 4.0 * by_sines(tau, s), 1e-12));
  }
}

TEST_CASE("the exact field of the rod obeys the heat equation") {
  // Central differences of second order; fourth derivatives are up to 4 * 32/pi^3 (5 pi/3)^4 there.
  const double h = 1e-3;
  for (const double t : {1.0, 2.0, 5.0}) {
    for (const double x : {0.4, 1.5, 2.2}) {
      const double rate = (u(t + h, x) - u(t - h, x)) / (2.0 * h);
      const double bend = (u(t, x + h) - 2.0 * u(t, x) + u(t, x - h)) / (h * h);
      CHECK_THAT(5.0 * rate, WithinAbs(2.0 * bend, 1e-5));
    }
  }
}
