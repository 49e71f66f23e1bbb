#pragma once

#include <vector>

namespace samara::benchmarks {

/// The gusts of the scalar loop.
struct ScalarGusts {
  double sigma = 0.0;  ///< [m/s]
  double T = 0.0;      ///< of a particle of the fluid [s]
  double C_0 = 6.0;
};

/// What one would write first: one flight after another, std::mt19937, the classical Runge-Kutta method with the
/// compiled law of the immersed body, the same Langevin equation with crossing trajectories and the same ramp.
/// @param x the 13 states at the start  @param p all parameters, complete  @returns mean of the last heights [m]
double fly_one_by_one(const std::vector<double>& x, const std::vector<double>& p, const ScalarGusts& gusts,
                      long flights, double step, long steps);

}  // namespace samara::benchmarks
