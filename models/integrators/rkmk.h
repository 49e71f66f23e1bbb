#pragma once

#include <memory>
#include <span>

#include "samara/models/integrators/integrate.h"

/// The method of Runge, Kutta and Munthe-Kaas of order four with fixed steps, for any model with an attitude
/// (a quaternion among ModelInfo::groups): the attitude turns by exponentials of rotation vectors, so its
/// quaternion keeps unit length to round-off whatever the step, and all other states take the classical
/// Runge-Kutta steps. (H. Munthe-Kaas, Runge-Kutta methods on Lie groups, BIT 38, 1998, 92-111; E. Hairer, C.
/// Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., 2006, IV.8.2.)
///
/// It keeps the attitude a rotation; it does not keep energy or momentum: see lie_group.h for that.
namespace samara::models {

struct RkmkOptions {
  /// Upper bound of the step [s]. Between two times asked for, steps are equal and end exactly on them.
  double step = 1e-3;
  /// Most steps of the whole trajectory; it stops at the last time asked for that they reach.
  long max_steps = 100000000;
};

/// For many integrations of one model; one per thread. Steps do not allocate.
class RkmkIntegrator {
 public:
  /// @throws ArgumentError if the step is not positive, or the model has no quaternion.
  explicit RkmkIntegrator(const ParametricModel& model, const RkmkOptions& options = {});
  ~RkmkIntegrator();
  RkmkIntegrator(RkmkIntegrator&&) noexcept;
  RkmkIntegrator& operator=(RkmkIntegrator&&) noexcept;

  /// The states at t = 0 are returned as given; quaternions of later ones have unit length.
  /// @param q free coordinates (SI)
  /// @param times not decreasing, from 0 on
  /// @throws ArgumentError as Integrator does.
  Trajectory operator()(std::span<const double> q, std::span<const double> times);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One trajectory, without keeping an integrator.
Trajectory integrate_rkmk(const ParametricModel& model, std::span<const double> q,
                          std::span<const double> times, const RkmkOptions& options = {});

}  // namespace samara::models
