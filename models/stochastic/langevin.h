#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "samara/models/stochastic/fluid_seen.h"

/// What the fluid seen by bodies and the particles of the fluid itself have in common.
namespace samara::models {

/// The energy at a place in the terms of the Langevin equation.
struct LangevinScales {
  double sigma = 0.0;  ///< deviation of a component [m/s]
  double T = std::numeric_limits<double>::infinity();
  double C_0 = 0.0;
  double L = 0.0;  ///< scale of von Karman's spectrum [m]

  LangevinScales(const Turbulence& at, const SeenOptions& options) {
    if (at.k == 0.0) return;
    // An energy that is none makes what sees it not finite, and that alone: other realisations go on.
    if (!(at.k > 0.0 && at.epsilon > 0.0 && std::isfinite(at.k) && std::isfinite(at.epsilon))) {
      sigma = std::numeric_limits<double>::quiet_NaN();
      return;
    }
    sigma = std::sqrt(2.0 / 3.0 * at.k);
    C_0 = options.C_0 > 0.0
              ? options.C_0
              : structure_constant(std::sqrt(20.0 / 3.0) * at.k / std::sqrt(options.viscosity * at.epsilon));
    T = 4.0 * at.k / (3.0 * C_0 * at.epsilon);
    L = 0.43 * at.k * std::sqrt(at.k) / at.epsilon;
  }

  /// Below which a step changes neither the energy nor the gust by much [s], for a particle of that speed.
  double time_scale(const Eigen::Vector3d& gradient, double speed) const {
    const double slope = gradient.norm() * speed;
    return slope > 0.0 ? std::min(T, sigma / slope) : T;
  }
};

}  // namespace samara::models
