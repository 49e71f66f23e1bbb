#pragma once

#include <memory>
#include <span>

#include "samara/models/integrators/integrate.h"

/// The classical Runge-Kutta method of order four with fixed steps (W. Kutta, Z. Math. Phys. 46, 1901,
/// 435-453): the cheapest way to a trajectory whose accuracy is known to suffice, and the one that batches
/// take (batch/batch.h). It does not estimate its error: compare with half the step.
namespace samara::models {

struct Rk4Options {
  /// Upper bound of the step [s]. Between two times asked for, steps are equal and end exactly on them.
  double step = 1e-3;
  /// Most steps of the whole trajectory; it stops at the last time asked for that they reach.
  long max_steps = 100000000;
};

/// For many integrations of one model; one per thread. Steps do not allocate.
class Rk4Integrator {
 public:
  /// @throws ArgumentError if an option is outside its meaning.
  explicit Rk4Integrator(const ParametricModel& model, const Rk4Options& options = {});
  ~Rk4Integrator();
  Rk4Integrator(Rk4Integrator&&) noexcept;
  Rk4Integrator& operator=(Rk4Integrator&&) noexcept;

  /// Status not_finite: a state was infinite or not a number at one of the times; `reached` is the time
  /// before it. No sensitivities: batches have them.
  /// @param q free coordinates (SI)
  /// @param times not decreasing, from 0 on
  /// @throws ArgumentError as Integrator does.
  Trajectory operator()(std::span<const double> q, std::span<const double> times);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One trajectory, without keeping an integrator.
Trajectory integrate_rk4(const ParametricModel& model, std::span<const double> q,
                         std::span<const double> times, const Rk4Options& options = {});

}  // namespace samara::models
