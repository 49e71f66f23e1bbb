#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"
#include "samara/pgd/axes/axis_transform.h"

/// What leaves the motion of a model as it is, found in its equations: whether they know the time, which states are
/// angles, and which half turns of the body and which reflections they do not notice.
namespace samara::codebooks {

/// States that move as others do: x becomes linear * x + shift, and f(x) linear * f(x).
struct MotionImage {
  Eigen::MatrixXd linear;  ///< states x states, orthogonal
  Eigen::VectorXd shift;   ///< of an angle: pi, with its sign
  std::string name;        ///< for readers: "a half turn of theta by pi", "a reflection of w, theta"

  Eigen::VectorXd of(const Eigen::VectorXd& x) const { return linear * x + shift; }
  Eigen::VectorXd back(const Eigen::VectorXd& x) const { return linear.transpose() * (x - shift); }
};

struct MotionSymmetry {
  bool autonomous = true;
  std::vector<bool> angles;  ///< per state: whether f is periodic in it with a full turn
  /// That f does not notice: half turns, reflections, and one after the other.
  std::vector<MotionImage> images;
  Eigen::VectorXd sizes;  ///< the largest of each rate that was found in the box
};

/// The interval of a free coordinate, and how it is drawn: evenly in its transform.
struct DrawnInterval {
  double lower = 0.0;
  double upper = 0.0;
  pgd::Transform transform = pgd::Transform::none;
};

/// Whether two values of f are the same to round-off: each rate to 1e-9 of itself, and to a few last digits of its
/// size, which is what terms that cancel leave. @param sizes of the rates
bool are_same_rates(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& sizes);

/// By values of f at 256 points of the box, half of them at its ends in most coordinates: a symmetry is taken as one if
/// it holds to round-off at all of them where f has values, and those are at least half. What breaks it in a small part
/// of the box only may be missed: compare f where an image is used. Half turns are those of each angle, and of a
/// quaternion about the three axes of the body; other states keep their sign or change it, whatever fits (of up to
/// twelve states). A reflection changes the signs of some states and nothing else; all that f keeps are listed, of
/// models without groups of states (vectors, quaternions).
/// @param box of the free coordinates
/// @param window of time, over which and a little beyond f is compared with that at 0 [s]
MotionSymmetry motion_symmetry(const models::ParametricModel& model, std::span<const DrawnInterval> box,
                               double window);

}  // namespace samara::codebooks
