#pragma once

#include <span>
#include <vector>

#include "samara/models/stochastic/fluid_seen.h"

/// Particles of the fluid itself in turbulence: smoke, spores, the fluid that a body is compared with.
namespace samara::models {

struct ParticleOptions {
  double step = 1e-3;  ///< upper bound [s]; steps end on the times asked for
  std::uint64_t seed = 1;
  double C_0 = 0.0;            ///< as in SeenOptions
  double viscosity = 1.5e-5;   ///< as in SeenOptions [m^2/s]
  int threads = 0;             ///< 0: as many as the machine has
  long max_steps = 100000000;  ///< most steps of a particle
};

/// Per time, one particle a column, world axes.
struct ParticlePaths {
  std::vector<Eigen::Matrix3Xd> position;  ///< [m]
  std::vector<Eigen::Matrix3Xd> velocity;  ///< mean and turbulent [m/s]
};

/// Follows particles from where they start at t = 0, each with turbulence of its own. Velocity and position make one
/// exact step together while T, sigma and its gradient hold: <x^2> is Taylor's at any step in homogeneous turbulence.
/// Where the energy has a gradient, a step of T/10 keeps a mixed fluid mixed to 6 %. Particles go on wherever the flow
/// says something, `inside` or not; what is not finite there makes them so.
/// @param start positions at t = 0, one a column
/// @param times not decreasing, from 0 on
/// @throws ArgumentError if an option, a time or a position is outside its meaning.
ParticlePaths follow_fluid(const TurbulentFlow& flow, const Eigen::Matrix3Xd& start,
                           std::span<const double> times, const ParticleOptions& options = {});

}  // namespace samara::models
