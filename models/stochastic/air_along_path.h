#pragma once

#include <cstdint>
#include <limits>
#include <memory>

#include <Eigen/Core>

/// What the driver of realisations (realisations.h) asks about the fluid: its velocity where one body is, step by
/// step. The fluid seen in a turbulent flow (fluid_seen.h) and a random field of wind drawn for each realisation are
/// two answers to it.
///
/// World axes, z up, SI units.
namespace samara::models {

/// A body at the start of a step.
struct BodyOnPath {
  double t = 0.0;                                          ///< [s]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< over the ground [m/s]
  Eigen::Matrix3d attitude = Eigen::Matrix3d::Identity();  ///< R_WB; identity for bodies without one
  Eigen::Vector3d air = Eigen::Vector3d::Zero();           ///< what it was told the velocity is here [m/s]
  /// What a sudden change of the air changes of its velocity, (m + M)^-1 (m_f + M), both in body axes: the identity for
  /// a body as heavy as the fluid, about zero for a heavy one.
  Eigen::Matrix3d follows = Eigen::Matrix3d::Zero();
  /// Of what else changes its velocity (weight, drag, lift), as in the step before [m/s^2].
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  /// In which drag takes up the rest of such a change, |(m + M) u_r|/|F|; asked for by AirAlongPath::needs_response,
  /// otherwise 0 [s]
  double response_time = 0.0;

  /// What a change of the air changes of its velocity at once.
  Eigen::Vector3d followed(const Eigen::Vector3d& change) const {
    return attitude * (follows * (attitude.transpose() * change));
  }
  /// Where it will be after a step of length h [s], over which the air changes by `change` [m/s].
  Eigen::Vector3d position_after(double h, const Eigen::Vector3d& change) const {
    return position + h * velocity + 0.5 * h * (followed(change) + h * acceleration);
  }
};

/// The air where the body is at the end of a step.
struct AirSeen {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the fluid [m/s]
  /// gradient(i, j) = d velocity_i/d x_j of the part that is a field [1/s]: by it the acceleration along the fluid's
  /// path differs from that along the body's.
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();  ///< angular velocity of a rotational gust [rad/s]
  /// In which the air changes along the path [s]: steps should be shorter than a tenth of it
  double time_scale = std::numeric_limits<double>::infinity();
  bool inside = true;  ///< false: the body has left the flow, and its realisation ends
};

/// The air along the path of one realisation; has a state, belongs to one thread.
class AirAlongPath {
 public:
  virtual ~AirAlongPath() = default;

  /// The air at the start; called once, before all steps.
  virtual AirSeen start(const BodyOnPath& body) = 0;

  /// The air at the end of a step of length h [s] from where the body is, at position_after().
  virtual AirSeen step(const BodyOnPath& body, double h) = 0;

  /// Whether `response_time` is of use at the next step: it costs as much as the step itself.
  virtual bool needs_response() const { return false; }
};

/// Where the air of every realisation comes from. Immutable: called from several threads at once.
class AirSource {
 public:
  virtual ~AirSource() = default;

  /// @param number of the realisation: the same bits for the same number, whatever else is asked for
  /// @param mirrored all that is random with the other sign: the antithetic partner of the same number
  virtual std::unique_ptr<AirAlongPath> realisation(std::uint64_t number, bool mirrored) const = 0;
};

}  // namespace samara::models
