#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"
#include "samara/motion/ghost/pose_path.h"

/// The invisible force: what would have to act on a body, besides all that its model knows, so that it moves as it
/// does.
///
/// A motion that is a solution of the model needs none, but for what its frames hide; a recording that was cut, blended
/// or shifted needs much, however smooth it looks. Of the wrench
///
///   ghost = M (nu' of the path - nu' of the model at the same pose and velocities),
///
/// M is the inertia of body and fluid, found from the kinetic energy of the model, and nu the velocity of the body's
/// origin and its rotation rate in body axes.
///
///     const GhostForce found = ghost_force(leaf, path);                       // at the coefficients of `leaf`
///     const GhostForce best = ghost_force(leaf, path, {.box = {{"C_T", {0.8, 1.4}}}});
///     best.box->ghost.force_sizes.max;                                        // at the best ones inside the box
namespace samara::motion {

/// Sizes of a wrench along a path.
struct GhostSizes {
  double rms = 0.0, median = 0.0, quantile90 = 0.0, max = 0.0;
};

struct CoefficientRange {
  double lower = 0.0, upper = 0.0;
};

struct GhostOptions {
  /// Coefficients that may be chosen so that little force is left, with their ranges. The model must be affine in them
  /// (ModelInfo::affine_in), and the course, if any, is not asked for them.
  std::map<std::string, CoefficientRange> box = {};
  /// In each window of so many frames the chosen coefficients are straight lines in time.
  int window = 8;
};

/// Force in net weights |m - m_displaced| g, torque about the body's origin in net weights times the semi-length.
struct GhostSeries {
  Eigen::VectorXd force, torque;  ///< sizes, one per frame
  GhostSizes force_sizes, torque_sizes;
};

struct GhostForce {
  Eigen::VectorXd times;  ///< of the frames of which something is said: all but kEndFrames at each end
  GhostSeries declared;   ///< at the coefficients of the model, or of its course

  /// At the best coefficients of the box.
  struct Box {
    std::vector<std::string> names;
    GhostSeries ghost;
    Eigen::MatrixXd coefficients;  ///< frames x names
    /// How much the coefficients would have to move, each in widths of its range and all of them on average, from one
    /// minimum of speed to the next: what thrashes hides forces.
    double travel = 0.0;
  };
  std::optional<Box> box;

  /// What noise does to these figures.
  struct Noise {
    PathNoise frames;                  ///< of a frame [m, rad]
    double force = 0.0, torque = 0.0;  ///< rms of the ghost that it gives alone, by accelerations
    /// Whether the declared force is no more than one and a half of it, and it is more than a hundredth of the weight.
    bool decides = false;
  };
  std::optional<Noise> noise;  ///< none of fewer than kFewestFrames frames

  double net_weight = 0.0;   ///< the unit of force [N; N/m of a planar model]
  double semi_length = 0.0;  ///< the unit of lengths in torques [m]
  int events = 0;            ///< as EventFinder has them
};

/// @param model all of whose parameters are fixed; coefficients that change are those of a following() model
/// @throws ArgumentError for a path that path_rates() refuses, a model that has no velocities in body axes (vx, vy,
/// w; ux, .., wz), no kinetic energy or no term "gravity and buoyancy", a path in a plane for a model in space or the
/// reverse, coefficients in which the model is not affine, empty ranges, fewer than 2 frames a window, or a path so
/// fast that its forces are no numbers.
GhostForce ghost_force(const models::ParametricModel& model, const PosePath& path,
                       const GhostOptions& options = {});

}  // namespace samara::motion
