#pragma once

#include <Eigen/Core>

#include "samara/motion/records/motion_record.h"

/// A record without its noise, as far as smoothing takes it, and what is left of it: features subtract that from
/// every variance. Without it all steady motions with noise are called flutter.
namespace samara::motion {

/// Local quadratics over an odd number of frames.
struct SmoothedMotion {
  Eigen::VectorXd times;
  Eigen::MatrixX3d positions, velocities;  ///< m, m/s
  Eigen::MatrixX3d normals;                ///< unit vectors; no rows: not known
  Eigen::VectorXd angles;                  ///< rad, unwrapped; no rows: not planar, or not known
  double position_noise = 0.0;             ///< m, standard deviation left in a coordinate
  double velocity_noise = 0.0;             ///< m/s, likewise in a component
  int ground_directions = 2;               ///< horizontal ones with noise in them; 1 where y never changes
  double angle_noise = 0.0;                ///< rad, left in an angle, or in a component of the normal
  double frame_angle = 0.0;  ///< rad, largest turn of the plate in the time of one frame, as it was seen

  Eigen::Index frame_count() const { return times.size(); }
  bool is_planar() const { return angles.size() > 0; }
  bool has_attitude() const { return normals.rows() > 0 || angles.size() > 0; }
};

/// The span of the quadratics is the smallest that leaves 2 % of the mean speed in a velocity and 0.04 rad in an
/// angle, unless their residuals grow beyond the noise before: then they no longer follow the motion.
/// Where frames are missing, the smoothed motion goes on by straight lines, so that its frames are even in time.
/// @throws ArgumentError as check(record) and even_frames() (even_frames.h)
SmoothedMotion smoothed(const MotionRecord& record);

/// Frames first, .., first + count - 1.
SmoothedMotion part(const SmoothedMotion& motion, Eigen::Index first, Eigen::Index count);

}  // namespace samara::motion
