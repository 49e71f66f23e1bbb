#pragma once

#include <Eigen/Core>

#include "samara/flow/momentum/momentum_step.h"

namespace samara::flow {

/// What the fluid does to the body in a step, per length of span in the plane [density U^2 l, l^2 for the moment].
struct BodyLoads {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  /// Its part by pressure on the cells beside the body.
  Eigen::Vector3d pressure = Eigen::Vector3d::Zero();
  double moment = 0.0;  ///< about the body's place as it is, about z
};

/// The momentum that the body takes: pressure where openness changes across a cell, what walls took, and what entered the
/// control volumes of closed faces. The last is no small thing: half of what arrives at a stagnation point ends there.
///
/// Of a body that moves, closed faces take it by the velocity relative to them, and what fluid is left beside them has the
/// body's acceleration. The body's own inertia is no part of it.
/// @param moves whether it does; else only the pose's place matters
BodyLoads surface_loads(const MacGrid& grid, const Openness& open, const MomentumStep& momentum,
                        const FlowState& state, const BodyPose& pose, bool moves);

/// The same force from the balance over a box of cells around the body, of which only the border and the change of
/// momentum inside are looked at: what flowed in and was not stored. The two agree to rounding.
Eigen::Vector3d box_force(const MacGrid& grid, const Openness& open, const MomentumStep& momentum,
                          const FlowState& state, const BodyPose& pose, bool moves, const Range& box,
                          double step);

/// Cells around a body with a margin of some of them, within the unknown faces of the domain.
Range control_box(const MacGrid& grid, const PlacedShape& body, int margin_cells);

}  // namespace samara::flow
