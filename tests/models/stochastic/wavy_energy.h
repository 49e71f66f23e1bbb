#pragma once

#include <cmath>
#include <numbers>

#include "samara/models/stochastic/turbulent_flow.h"

/// The constant of the structure function in the tests of turbulence.
inline constexpr double kC0 = 6.0;

/// epsilon for which T is as given.
inline double dissipation(double k, double T) {
  return 4.0 * k / (3.0 * kC0 * T);
}

/// sigma = (1 + 0.8 cos 2 pi z) decay(t) in a stream along z; T = 0.1 s.
class WavyEnergy final : public samara::models::TurbulentFlow {
 public:
  WavyEnergy(double stream, double decay) : stream_(stream), decay_(decay) {}
  samara::models::AmbientSample sample(double, const Eigen::Vector3d&) const override {
    return {.velocity = {0.0, 0.0, stream_}};
  }
  samara::models::Turbulence turbulence(double t, const Eigen::Vector3d& position) const override {
    const double angle = 2.0 * std::numbers::pi * position.z();
    const double size = std::exp(-decay_ * t);
    const double sigma = size * (1.0 + 0.8 * std::cos(angle));
    const double k = 1.5 * sigma * sigma;
    return {.k = k,
            .epsilon = dissipation(k, 0.1),
            .sigma_gradient = {0.0, 0.0, -size * 1.6 * std::numbers::pi * std::sin(angle)}};
  }
  double length() const override { return 1.0; }

 private:
  double stream_, decay_;
};
