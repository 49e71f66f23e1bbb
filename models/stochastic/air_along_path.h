#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include <Eigen/Core>

/// What the driver of realisations (realisations.h) asks about the fluid: its velocity where one body is, step by
/// step. The fluid seen in a turbulent flow (fluid_seen.h) and a random field of wind drawn for each realisation are
/// two answers to it. The driver asks for several realisations side by side, which are one after the other where the
/// source knows no better.
///
/// World axes, z up, SI units.
namespace samara::models {

/// A body at the start of a step.
struct BodyOnPath {
  double t = 0.0;                                          ///< [s]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< over the ground [m/s]
  Eigen::Matrix3d attitude = Eigen::Matrix3d::Identity();  ///< R_WB; identity for bodies without one
  /// 1 along the axes of the world that it can move along, otherwise 0: in a plane (1, 0, 1).
  Eigen::Vector3d axes = Eigen::Vector3d::Ones();
  Eigen::Vector3d air = Eigen::Vector3d::Zero();  ///< the velocity it was told, along its axes [m/s]
  /// What a sudden change of the air changes of its velocity, (m + M)^-1 (m_f + M), both in body axes: the identity for
  /// a body as heavy as the fluid, about zero for a heavy one.
  Eigen::Matrix3d follows = Eigen::Matrix3d::Zero();
  /// Of what else changes its velocity (weight, drag, lift), as in the step before [m/s^2].
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  /// In which drag takes up the rest of such a change, |(m + M) u_r|/|F| [s]; 0 unless AirAlongPath::needs_response
  /// asks for it.
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
  /// Of the fluid [m/s]. Of this and of `rotation` a body takes what it can move by.
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  /// gradient(i, j) = d velocity_i/d x_j in the middle of the step, as far as it is known (the mean, and the
  /// deviation of the gusts) [1/s]: by it the acceleration along the fluid's path differs from that along the body's,
  /// and it loads the added mass.
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();  ///< angular velocity of a rotational gust [rad/s]
  /// In which the air changes along the path [s]: steps should be shorter than a tenth of it
  double time_scale = std::numeric_limits<double>::infinity();
  bool inside = true;  ///< false: the body leaves the flow, and its realisation ends with this step
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

/// Vectors and matrices of bodies side by side: a row for each body, a column for each component, so that a
/// component of all bodies is contiguous.
using VectorsByLane = Eigen::Array<double, Eigen::Dynamic, 3>;
using MatricesByLane = Eigen::Array<double, Eigen::Dynamic, 9>;  ///< column after column of each matrix

/// Bodies side by side at the start of a step, each as BodyOnPath has it.
struct BodiesOnPath {
  explicit BodiesOnPath(Eigen::Index lanes);

  Eigen::Index lanes() const { return flies.size(); }
  BodyOnPath body(Eigen::Index lane) const;
  void set(Eigen::Index lane, const BodyOnPath& body);

  double t = 0.0;
  VectorsByLane position, velocity, air, acceleration;
  MatricesByLane attitude;
  Eigen::ArrayXd response_time;
  Eigen::Vector3d axes = Eigen::Vector3d::Ones();     ///< of all
  Eigen::Matrix3d follows = Eigen::Matrix3d::Zero();  ///< of all
  Eigen::ArrayXd flies;  ///< 1, or 0 where there is no body under way, whose numbers mean nothing
};

/// The air where each of them is at the end of a step, as AirSeen has it.
struct AirsSeen {
  explicit AirsSeen(Eigen::Index lanes);

  AirSeen seen(Eigen::Index lane) const;
  void set(Eigen::Index lane, const AirSeen& seen);

  VectorsByLane velocity, rotation;
  MatricesByLane gradient;
  Eigen::ArrayXd time_scale;
  Eigen::ArrayXd inside;  ///< 1, or 0
  /// 1, or 0: whether `response_time` is of use at the next step (AirAlongPath::needs_response).
  Eigen::ArrayXd needs_response;
};

/// The air along the paths of several realisations, in lanes; has a state, belongs to one thread.
class AirAlongPaths {
 public:
  virtual ~AirAlongPaths() = default;

  virtual void start(const BodiesOnPath& bodies, AirsSeen& seen) = 0;
  /// As AirAlongPath::step, of the bodies that fly.
  virtual void step(const BodiesOnPath& bodies, double h, AirsSeen& seen) = 0;
};

/// A realisation by its number, or its antithetic partner.
struct Draw {
  std::uint64_t number = 0;
  bool mirrored = false;  ///< all that is random with the other sign
};

/// Where the air of every realisation comes from. Immutable: called from several threads at once.
class AirSource {
 public:
  virtual ~AirSource() = default;

  /// @param number of the realisation: the same bits for the same number, whatever else is asked for
  /// @param mirrored all that is random with the other sign: the antithetic partner of the same number
  virtual std::unique_ptr<AirAlongPath> realisation(std::uint64_t number, bool mirrored) const = 0;

  /// The same of several side by side, the first draw in the first lane, each with the bits that it has alone.
  /// @param lanes at least as many as draws
  virtual std::unique_ptr<AirAlongPaths> side_by_side(std::span<const Draw> draws, Eigen::Index lanes) const;
};

}  // namespace samara::models
