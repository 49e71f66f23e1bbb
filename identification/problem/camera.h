#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_problem.h"

/// Internal to identification/: what a camera makes of a motion whose scale and axes it does not quite have.
namespace samara::identification {

/// Names in results: the factor on lengths, and the turn by an angle ("turn") or about an axis ("turn about
/// x").
constexpr const char* kCameraScale = "scale";
constexpr const char* kCameraTurn = "turn";

/// How one camera sees places, angles and attitudes of the model:
///
///     place -> (1 + s) R place,   angle -> angle + r,   q_WB -> q(r) q_WB
///
/// with the relative error s of lengths and the turn R by the angle r, or the rotation vector r, in world
/// axes.
struct CameraView {
  /// (1 + s) R, of as many rows and columns as there are axes, and its derivatives by s and by r.
  Eigen::Matrix3d map = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d by_scale = Eigen::Matrix3d::Identity();
  std::array<Eigen::Matrix3d, 3> by_turn = {};
  double angle = 0.0;  ///< r, of two axes
  /// The turn as a quaternion (w, x, y, z), and its derivatives by r; of three axes.
  Eigen::Vector4d turn = Eigen::Vector4d::UnitX();
  Eigen::Matrix<double, 4, 3, Eigen::DontAlign> turn_by_turn = decltype(turn_by_turn)::Zero();

  CameraView() = default;
  /// @param axes 1, 2 or 3
  /// @param turn none, one or three numbers
  CameraView(std::size_t axes, double scale_error, std::span<const double> turn);
  /// @param own unknowns of a segment
  CameraView(const Camera& camera, const double* own);

  /// q(r) p as a matrix on p, and as a matrix on q(r).
  Eigen::Matrix4d on_attitude() const;
  static Eigen::Matrix4d on_turn(const Eigen::Vector4d& attitude);
};

/// The outputs that are coordinates of the place.
/// @throws ArgumentError for unknown outputs, for one that is named twice or is no place, and where a turn
/// has neither two nor three of them.
std::vector<std::string> camera_axes(const models::FamilyInfo& family, const CameraOptions& options);

/// Adds the unknowns of the camera, and what is known of them beforehand, if the options ask for any.
/// @throws ArgumentError as camera_axes(), where none of the axes is compared, for angles that are none, and
/// for axes or angles without scale or rotation.
void add_camera(const models::FamilyInfo& family, const FitOptions& options, FitProblem& problem);

/// Names of the unknowns, in their order: "scale", "turn", "turn about x".
std::vector<std::string> camera_unknowns(const FitProblem& problem);

}  // namespace samara::identification
