#pragma once

#include <memory>

#include <Eigen/Core>

#include "samara/models/interface/model.h"

/// A body in a wind that varies in space and time.
///
///   class Vortex : public samara::models::AmbientFlow { ... };
///   auto model = samara::models::immersed_body_in(std::make_shared<Vortex>());
namespace samara::models {

/// The undisturbed fluid at a point, in world axes.
struct AmbientSample {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< w_air [m/s]
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();  ///< gradient(i, j) = d w_air_i / d x_j [1/s]
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();      ///< d w_air/dt at a fixed point [m/s^2]
};

/// The velocity field of the undisturbed fluid. Immutable: called from several threads at once.
class AmbientFlow {
 public:
  virtual ~AmbientFlow() = default;

  /// @param position world axes [m]
  virtual AmbientSample sample(double t, const Eigen::Vector3d& position) const = 0;

  /// Over which way the field changes by its own size [m]. It sets the step of the differences below.
  virtual double length() const = 0;
};

/// The model `immersed_body` (same states, parameters, force terms) in that flow, which changes little over the
/// body: the velocity at the body's origin enters drag, lift and added mass, the accelerations D w_air/Dt and
/// dw_air/dt + (v . grad) w_air enter as pressure gradient and inertia, and the gradient loads the added mass M
/// with -(grad w_air)^T M (v - w_air): of a sphere in a shear the lift m_f/2 (w_air - v) x curl w_air (T. Auton,
/// J. Hunt, M. Prud'homme, J. Fluid Mech. 197 (1988) 241).
///
/// Its Jacobian takes the gradient that the flow supplies; second derivatives of the field, which the
/// accelerations bring in, are central differences of gradient and rate with a step of 6e-6 length(): good to
/// about 1e-10 of themselves for a smooth field.
/// @throws ArgumentError if there is no flow, or its length() is not positive and finite.
std::shared_ptr<const Model> immersed_body_in(std::shared_ptr<const AmbientFlow> flow);

}  // namespace samara::models
