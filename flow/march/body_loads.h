#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "samara/flow/momentum/momentum_step.h"

namespace samara::flow {

/// What the fluid does to the body in a step, per length of span in the plane [density U^2 l, l^2 for the moment].
struct BodyLoads {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  /// Its part by pressure on the cells beside the body.
  Eigen::Vector3d pressure = Eigen::Vector3d::Zero();
  double moment = 0.0;  ///< about the body's place as it is, about z: from x to y, against the angle
};

/// The control volumes of faces as they were before a body moved on.
class VolumesBefore {
 public:
  explicit VolumesBefore(const MacGrid& grid) : volume_(grid.faces(1.0)) {}

  /// Before `open` follows the body.
  void keep(const MacGrid& grid, const Openness& open);
  double volume(int d, Index c) const {
    return volume_[static_cast<std::size_t>(d)][static_cast<std::size_t>(c)];
  }
  bool was_closed(int d, Index c) const;

 private:
  FaceField volume_;  ///< in h^dimensions; 1 away from the body
  Range kept_ = {{0, 0, 0}, {0, 0, 0}};
  std::array<std::vector<Index>, 3> closed_;
};

/// A force on a body at a face.
struct FaceForce {
  int d = 0;
  Index at = 0;
  double force = 0.0;
};

/// What the body takes in a step beside the fluxes, because control volumes change as it moves on: they shrink by
/// steps, and not by what is swept out of them in each, and a face that closes hands over the fluid that was left
/// beside it. By the velocity relative to the body; over a way of many cells the sum is what the fluid has lost.
std::vector<FaceForce> reshaping_forces(const MacGrid& grid, const Openness& open,
                                        const VolumesBefore& before, const MomentumStep& momentum,
                                        const FlowState& state, const BodyPose& pose, double step);

/// The momentum that the body takes: pressure where openness changes across a cell, what walls took,
/// and what entered the control volumes of closed faces. The last is no small thing: half of what
/// arrives at a stagnation point ends there.
///
/// Of a body that moves, closed faces take it by the velocity relative to them, and what fluid is left beside them
/// has the body's acceleration. The body's own inertia is no part of it. The moment is that of the fluxes, which leave
/// out the transposed part of the molecular stress; turning_moment() is the rest.
/// @param moves whether it does; else only the pose's place matters
/// @param reshaping reshaping_forces() of the step; none of a held body
BodyLoads surface_loads(const MacGrid& grid, const Openness& open, const MomentumStep& momentum,
                        const FlowState& state, const BodyPose& pose, bool moves,
                        const std::vector<FaceForce>& reshaping);

/// Moment of the transposed part of the molecular stress about z. Over a closed surface its force sums to 0, and its
/// moment to -nu times the circulation about the body, which is that of its turning.
/// @param volume of the body, of a section its area
inline double turning_moment(const BodyPose& pose, double viscosity, double volume) {
  return 2.0 * viscosity * pose.angular_rate * volume;
}

/// The same force from the balance over a box of cells around the body, of which only the border and the change of
/// momentum inside are looked at: what flowed in and was not stored. The two agree to rounding. That says nothing of
/// `reshaping`, which both take as it is: it is held by what the fluid loses over a way of many cells.
Eigen::Vector3d box_force(const MacGrid& grid, const Openness& open, const MomentumStep& momentum,
                          const FlowState& state, const BodyPose& pose, bool moves,
                          const std::vector<FaceForce>& reshaping, const Range& box, double step);

/// Cells around a body with a margin of some of them, within the unknown faces of the domain.
Range control_box(const MacGrid& grid, const PlacedShape& body, int margin_cells);

}  // namespace samara::flow
