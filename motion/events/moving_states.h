#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/model.h"
#include "samara/motion/records/state_layout.h"

/// What of a model's states matters for where a motion can go on: place, velocity and attitude, and the state that
/// is left when translation, yaw and the body's symmetries are taken away.
namespace samara::motion {

/// One instant, in world axes: z up, planar motions in y = 0.
struct BodyMotion {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   ///< of the plate
};

/// Turns after which a body is the same; of one kind of body those that come later hold those before.
enum class BodySymmetry {
  none,
  half_turn,  ///< in the plane: by pi
  ellipsoid,  ///< in space: by pi about each of its three axes
  disc,       ///< in space: by any angle about its normal, and by pi about any axis across
};

/// The states of a model as motions. Immutable, shared between threads; at() and the reduced states do not allocate.
class MovingStates {
 public:
  /// @throws ArgumentError unless the model has x, y, theta, vx, vy, w (velocities along body axes), or x, y, z,
  /// qw, .., qz, ux, uy, uz, wx, wy, wz.
  MovingStates(const models::ModelInfo& info, BodySymmetry symmetry);
  /// With the symmetry that the model has at these parameters (all of them): disc if a = b and what else has a part
  /// along both is equal, none if its centre of buoyancy lies off its centre.
  static MovingStates of(const models::Model& model, std::span<const double> parameters);

  /// Of records: place, velocity and normal, nine numbers. They have no reduced states.
  static MovingStates of_record(bool is_planar);

  bool is_planar() const { return layout_.is_planar; }
  bool is_of_record() const { return is_of_record_; }
  std::size_t state_count() const { return count_; }
  /// Of states of a model.
  const StateLayout& layout() const { return layout_; }
  BodySymmetry symmetry() const { return symmetry_; }

  BodyMotion at(std::span<const double> state) const;
  /// Parts of that, for less.
  Eigen::Vector3d place(std::span<const double> state) const;
  double speed_square(std::span<const double> state) const;

  /// 5 in the plane: vx, vy, w, then sine and cosine of 2 theta (of theta, without symmetry). 9 in space: the unit
  /// vector downward in body axes, u, w; of a disc in axes whose x lies along the velocity across its normal.
  int reduced_size() const { return is_planar() ? 5 : 9; }
  void reduce(std::span<const double> state, std::span<double> reduced) const;

  /// Reduced states that are the same motion: 1, 2 or 4, the first being the state itself.
  int copies() const;
  /// Puts copy `k` in the place of a reduced state.
  void turn_to_copy(int k, std::span<double> reduced) const;

 private:
  MovingStates() = default;

  std::size_t count_ = 0;
  bool is_of_record_ = false;
  BodySymmetry symmetry_ = BodySymmetry::none;
  StateLayout layout_;
};

/// How far apart two reduced states are: the Euclidean distance of them times weights. In the plane vx, vy and w over
/// their deviations, the angle's sine and cosine over 1.2; in space the direction downward times 1.5, u over the rms
/// of its components times 1.5, w over that of its own.
class StateMetric {
 public:
  /// @param reduced one reduced state a row, at least two
  /// @throws ArgumentError if they are fewer, or do not differ
  static StateMetric fitted(const MovingStates& states, const Eigen::Ref<const Eigen::MatrixXd>& reduced);
  explicit StateMetric(Eigen::VectorXd weights) : weights_(std::move(weights)) {}

  const Eigen::VectorXd& weights() const { return weights_; }
  /// The place whose Euclidean distances are those of the metric.
  void place(std::span<double> reduced) const {
    for (std::size_t k = 0; k < reduced.size(); ++k) reduced[k] *= weights_[static_cast<Eigen::Index>(k)];
  }

 private:
  Eigen::VectorXd weights_;
};

}  // namespace samara::motion
