#pragma once

#include <optional>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"

namespace samara::models::wind {

/// What a wind needs to know of a body.
struct BodyOutline {
  double length = 0.0;  ///< [m]
  /// Of a flat one, along its axes x and y; else zero [m].
  Eigen::Vector2d semi_axes = Eigen::Vector2d::Zero();
};

/// From the parameters of a model without free coordinates: a and b, or what outline_radius() finds.
/// @param radius [m] of a disc in place of the body's own outline; 0: no mean over an outline
/// @throws ArgumentError if the model has no parameters that say its size, or the radius is
/// negative or not finite, or above 0 for a body that is not flat
BodyOutline outline_of(const ParametricModel& model, std::optional<double> radius = {});

}  // namespace samara::models::wind
