#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include <Eigen/Core>

#include "samara/identification/captures/capture.h"
#include "samara/models/interface/model.h"
#include "samara/motion/records/state_layout.h"

/// What is known of one motion, whether it was simulated or filmed: times, positions, and, if known, which way
/// the plate looks.
namespace samara::motion {

/// World axes: z up, x and y horizontal; SI, or the units of a dimensionless model.
struct MotionRecord {
  Eigen::VectorXd times;       ///< s, strictly increasing
  Eigen::MatrixX3d positions;  ///< frames x (x, y, z), m
  /// Unit normals of the plate in the world, frames x 3; no rows: not known. A normal and its opposite say the same
  /// of a plate whose sides look alike, but must follow each other without jumps.
  Eigen::MatrixX3d normals;
  /// Of a motion in the plane y = 0: angle of the chord above the horizontal, unwrapped, rad; no rows: not such a
  /// motion, or not known. Then there are no normals.
  Eigen::VectorXd angles;
  /// l, m: largest full length of the body (chord, diameter); 0: not known.
  double length = 0.0;
  /// Standard deviations of a frame's noise in a coordinate [m] and of an angle or a component of the normal [rad];
  /// empty: found from fourth differences.
  std::optional<double> position_noise, angle_noise;
  /// Frames that were left out because their place or attitude was not seen.
  Eigen::Index left_out = 0;

  Eigen::Index frame_count() const { return times.size(); }
  bool has_attitude() const { return normals.rows() > 0 || angles.size() > 0; }
  bool is_planar() const { return angles.size() > 0; }
};

/// Fewest frames of which anything is said.
inline constexpr Eigen::Index kFewestFrames = 12;

/// @throws ArgumentError naming the frame: sizes that differ, times that do not increase, numbers that are not
/// finite, normals that are no unit vectors (to 1e-3) or stand beside angles, fewer than kFewestFrames, a negative
/// length or noise.
void check(const MotionRecord& record);

/// Frames first, .., first + count - 1.
MotionRecord part(const MotionRecord& record, Eigen::Index first, Eigen::Index count);

/// The channel of a place (x, y, z), an angle, or a part of a quaternion. Places of dimensionless models are plain
/// numbers.
/// @throws as identification::refuse(), naming the capture and the channel that is missing, in pixels, or of another
/// dimension
const Eigen::VectorXd& pose_values(const identification::Capture& capture, const std::string& quantity);

/// The record of a capture. Its channels: x, y, z (z up), with qw, qx, qy, qz where the attitude was seen; or, of a
/// motion in a plane, x and y (up), with theta. Frames not seen are left out and counted.
/// @param length m, of the body; 0: not known
/// @throws as pose_values(), also for too few frames
MotionRecord record_of(const identification::Capture& capture, double length = 0.0);

/// Where the states of a model hold place and attitude of a body.
class MotionStates {
 public:
  /// @throws ArgumentError if the model has neither x, y, z with qw, qx, qy, qz, nor x, y with theta.
  explicit MotionStates(const models::ModelInfo& info);

  bool is_planar() const { return layout_.is_planar; }
  /// Place in the world: (x, 0, y) of a planar model.
  Eigen::Vector3d position(std::span<const double> state) const { return layout_.place(state); }
  Eigen::Vector3d normal(std::span<const double> state) const;
  double angle(std::span<const double> state) const;

  /// Largest full length of the body at these parameters: twice the largest of a, b, c, or of the semi-chord; chord,
  /// length or diameter; the diameter of a disc of the area, if that alone is known; 2 of a dimensionless plate (then
  /// its states decide); 0 if the model does not say.
  static double body_length(const models::Model& model, std::span<const double> parameters);

 private:
  StateLayout layout_;
};

/// A record put together frame by frame.
class RecordBuilder {
 public:
  RecordBuilder(const MotionStates& states, std::size_t frames);
  void add(double t, std::span<const double> state);
  std::size_t count() const { return times_.size(); }
  /// @param length m, see MotionRecord
  MotionRecord record(double length) const;

 private:
  const MotionStates& states_;
  std::vector<double> times_, numbers_;
};

}  // namespace samara::motion
