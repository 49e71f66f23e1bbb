#include "samara/models/stochastic/fluid_particles.h"

#include <array>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/normals.h"
#include "samara/base/require.h"
#include "samara/models/batch/batch_tasks.h"
#include "samara/models/integrators/trajectory_tools.h"
#include "samara/models/stochastic/langevin.h"

namespace samara::models {

namespace {

enum ParticleNoise : std::uint16_t { kVelocityNoise = 1, kPlaceNoise = 2 };

class FluidParticle {
 public:
  FluidParticle(const TurbulentFlow& flow, const ParticleOptions& options, std::uint64_t number,
                const Eigen::Vector3d& start)
      : flow_(flow),
        seed_(options.seed),
        options_({.C_0 = options.C_0, .viscosity = options.viscosity}),
        number_(number),
        x_(start),
        w_(normals(kVelocityNoise)) {}

  void step(double t, double h) {
    ++step_;
    const Eigen::Vector3d middle = x_ + 0.5 * h * velocity(t);
    const Turbulence energy = flow_.turbulence(t + 0.5 * h, middle);
    const LangevinScales scales(energy, options_);
    x_ += h * flow_.sample(t + 0.5 * h, middle).velocity;
    if (!(scales.sigma > 0.0)) return;
    const double a = h / scales.T;
    const LangevinStep step(a);
    const Eigen::Vector3d drift = scales.T * energy.sigma_gradient;
    const Eigen::Vector3d xi = normals(kVelocityNoise);
    x_ += scales.sigma * scales.T *
          (step.carry * w_ + (a - step.carry) * drift + step.shared * xi + step.rest * normals(kPlaceNoise));
    w_ = step.kept * w_ + step.carry * drift + step.noise * xi;
  }

  Eigen::Vector3d velocity(double t) const {
    return flow_.sample(t, x_).velocity + LangevinScales(flow_.turbulence(t, x_), options_).sigma * w_;
  }
  const Eigen::Vector3d& position() const { return x_; }

 private:
  Eigen::Vector3d normals(ParticleNoise stream) const {
    const std::array<double, 4> z =
        normals_at(seed_, {.realisation = number_, .step = step_, .stream = stream});
    return {z[0], z[1], z[2]};
  }

  const TurbulentFlow& flow_;
  std::uint64_t seed_;
  SeenOptions options_;
  std::uint64_t number_;
  std::uint64_t step_ = 0;
  Eigen::Vector3d x_, w_;
};

}  // namespace

ParticlePaths follow_fluid(const TurbulentFlow& flow, const Eigen::Matrix3Xd& start,
                           std::span<const double> times, const ParticleOptions& options) {
  check_step(options.step);
  check_times(times);
  check_max_steps(options.max_steps);
  if (!times.empty() && are_too_many(times, options.step, options.max_steps))
    throw ArgumentError(
        fmt::format("steps of {} s to t = {} s are more than {}; a longer step or fewer times were expected",
                    options.step, times.back(), options.max_steps));
  require_not_negative(options.C_0, "C_0");
  require_positive(options.viscosity, "viscosity [m^2/s]");
  if (!start.allFinite())
    throw ArgumentError("a start of a particle is not finite; positions in m were expected");
  ParticlePaths paths;
  paths.position.assign(times.size(), Eigen::Matrix3Xd(3, start.cols()));
  paths.velocity = paths.position;
  arena_of(options.threads).execute([&] {
    parallel_for(start.cols(), [&](Eigen::Index n) {
      FluidParticle particle(flow, options, static_cast<std::uint64_t>(n), start.col(n));
      double t = 0.0;
      for (std::size_t k = 0; k < times.size(); ++k) {
        const EqualSteps steps = equal_steps(t, times[k], options.step);
        for (long step = 0; step < steps.count; ++step)
          particle.step(t + static_cast<double>(step) * steps.length, steps.length);
        t = times[k];
        paths.position[k].col(n) = particle.position();
        paths.velocity[k].col(n) = particle.velocity(t);
      }
    });
  });
  return paths;
}

}  // namespace samara::models
