#pragma once

#include <filesystem>
#include <string>

#include <Eigen/Core>

#include "samara/models/bodies/kinematic_paths.h"

namespace samara::motion {

/// A path that a fall is asked to follow: a polyline that goes down, or one with times. World axes, z up; a motion in a
/// plane has y = 0.
///
/// Without times the target of a body is the point of the sketch at its own height, above the first and below the last
/// point those two; with times it is the point of that time.
class Sketch {
 public:
  /// @param points in rows  @param times none, or one for each point
  /// @throws ArgumentError for fewer than two points, numbers that are not finite, times that do not increase, or,
  /// without times, a point that is not below the one before.
  explicit Sketch(Eigen::MatrixX3d points, Eigen::VectorXd times = {});

  bool is_timed() const { return times_.size() > 0; }
  Eigen::Vector3d target(double t, const Eigen::Vector3d& position) const {
    Eigen::Index any = 0;
    return target(t, position, any);
  }
  /// @param near number of the point that comes next, where it is looked for first; set to what it is
  Eigen::Vector3d target(double t, const Eigen::Vector3d& position, Eigen::Index& near) const;

  /// d(target)/d(height of the body): of a sketch with times, zero.
  Eigen::Vector3d slope(const Eigen::Vector3d& position) const;

  const Eigen::MatrixX3d& points() const { return points_; }
  /// None, or one for each point.
  const Eigen::VectorXd& times() const { return times_; }
  double top() const { return points_(0, 2); }
  double bottom() const { return points_(points_.rows() - 1, 2); }
  /// Of a sketch with times.
  double end_time() const { return times_[times_.size() - 1]; }

 private:
  Eigen::Index next_point(double key) const;

  Eigen::MatrixX3d points_;
  Eigen::VectorXd times_;
  /// What the target is looked up by, decreasing or increasing: heights, or times.
  Eigen::VectorXd keys_;
};

/// Lines by the unified trajectory functions of the dissertation, (3.6) and (3.7) (kinematic_paths.h): what a fall is
/// to look like, to begin with; they obey no law of motion. Moved so that they begin at `from`, down to the height
/// `bottom`, 64 points a period, without times.
/// @throws ArgumentError as at() of the path, for one that does not go down all the way, or takes more than 1e5 points
Sketch sketch_of(const models::SideToSidePath& path, const Eigen::Vector3d& from, double bottom);
Sketch sketch_of(const models::RosePath& path, const Eigen::Vector3d& from, double bottom);

/// Those of a model whose fall follows a sketch.
struct SketchUnits {
  std::string length = "m", time = "s";
};

/// Columns x, y, z, or x, y of a motion in a plane, y up; t, if it is timed. Units stand in the header, "x[cm]"; SI
/// where they do not.
/// @param planar whether y, and not z, is up
/// @throws InputError with file and line, also for a unit of another dimension than the model's
Sketch read_sketch(const std::filesystem::path& path, bool planar, const SketchUnits& units = {});

}  // namespace samara::motion
