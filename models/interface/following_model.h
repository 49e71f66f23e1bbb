#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/model.h"

/// Models whose coefficients change in time: x' = f(t, x, p(t)), where some of the parameters p follow a
/// course that is given beforehand, or by parameters of its own (the values at knots, for a fit).
///
/// The motion is that of the model with the coefficients of each instant: what the fluid remembers enters
/// through the course alone (dissertation, section 5.1.2, "instantaneous coefficients").
///
///     const auto steered = following(find_model("falling_plate"), course);   // a ParameterCourse
///     integrate(ParametricModel(steered, fixed, {}), {}, times);
namespace samara::models {

/// What parameters do in time. Immutable, safe to share between threads.
class ParameterCourse {
 public:
  virtual ~ParameterCourse() = default;

  /// Names of the parameters of a model that follow it.
  virtual const std::vector<std::string>& followed() const = 0;

  /// Its own parameters, which take the places of those that follow; none by default.
  virtual std::vector<ParameterInfo> parameters() const { return {}; }

  /// Values of followed() at time t, in their order. Defined at all times: integrators look past the end.
  /// @param own values of parameters()
  virtual void values(double t, std::span<const double> own, std::span<double> followed) const = 0;

  /// d(followed)/d(own), followed x own, all of it to be set. Not called if there are no own parameters.
  virtual void derivatives(double t, std::span<const double> own, Eigen::Ref<Eigen::MatrixXd> by_own) const;
};

/// The model of the same name whose parameters are those of `model` that do not follow, in their order, and
/// then the course's own. Defaults that depend on what follows (mu2 on mu1) follow too.
/// @throws ArgumentError if the course names what is no parameter (the nearest is named), or one twice.
std::shared_ptr<const Model> following(std::shared_ptr<const Model> model,
                                       std::shared_ptr<const ParameterCourse> course);

}  // namespace samara::models
