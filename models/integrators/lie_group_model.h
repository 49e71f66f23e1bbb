#pragma once

#include <memory>
#include <span>

#include "samara/models/integrators/integrate.h"
#include "samara/models/integrators/lie_group.h"
#include "samara/models/interface/parametric_model.h"

namespace samara::models {

/// The integrator on the group of rigid motions (lie_group.h) for models of one rigid body: the inertia is read from
/// the model's kinetic energy, the wrench is the sum of its force terms but "inertia". Where these do not make up the
/// model's equations (an inertia that changes, states of another kind) it is refused.
class LieGroupModelIntegrator {
 public:
  /// @throws ArgumentError if an option is outside its meaning, or the model has other states than a position, a
  ///   quaternion, velocity and angular velocity in body axes, no energy or no force terms
  explicit LieGroupModelIntegrator(const ParametricModel& model, const LieGroupOptions& options = {});
  ~LieGroupModelIntegrator();
  LieGroupModelIntegrator(LieGroupModelIntegrator&&) noexcept;
  LieGroupModelIntegrator& operator=(LieGroupModelIntegrator&&) noexcept;

  /// @param q free coordinates (SI)  @param times not decreasing, from 0 on
  /// @throws ArgumentError as Integrator, and where the model is not Kirchhoff's equations with a constant inertia
  Trajectory operator()(std::span<const double> q, std::span<const double> times);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::models
