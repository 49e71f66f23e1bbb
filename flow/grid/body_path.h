#pragma once

#include <cmath>
#include <functional>

#include <Eigen/Core>

namespace samara::flow {

/// How a rigid body moves at a time: its centre, and its turn about z, by the angle of attack of PlacedShape, which
/// grows against the sense of z. In body lengths and U.
struct BodyPose {
  Eigen::Vector3d place = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero(),
                  acceleration = Eigen::Vector3d::Zero();
  double angle = 0.0, angular_rate = 0.0, angular_acceleration = 0.0;

  /// Of the material point of the body that is at x.
  Eigen::Vector3d velocity_at(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d r = x - place;
    return velocity + angular_rate * Eigen::Vector3d(r.y(), -r.x(), 0.0);
  }
  Eigen::Vector3d acceleration_at(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d r = x - place;
    return acceleration + angular_acceleration * Eigen::Vector3d(r.y(), -r.x(), 0.0) -
           angular_rate * angular_rate * Eigen::Vector3d(r.x(), r.y(), 0.0);
  }
  bool is_finite() const {
    return place.allFinite() && velocity.allFinite() && acceleration.allFinite() &&
           std::isfinite(angle + angular_rate + angular_acceleration);
  }
};

/// The pose at a time.
using BodyPath = std::function<BodyPose(double time)>;

}  // namespace samara::flow
