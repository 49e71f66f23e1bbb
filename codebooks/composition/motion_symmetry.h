#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"

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
  std::vector<MotionImage>
      images;  ///< that f does not notice: half turns, reflections, and one after the other
};

/// By values of f, at points drawn over the box of the free coordinates: a symmetry is taken as one if it holds to
/// round-off at all of them. Half turns are those of each angle, and of a quaternion about the three axes of the body;
/// other states keep their sign or change it, whatever fits (of up to twelve states). Reflections change signs alone,
/// each in its own way; of models without groups of states (vectors, quaternions).
/// @param lower, upper of the free coordinates  @param later time at which f is compared with that at 0 [s]
MotionSymmetry motion_symmetry(const models::ParametricModel& model, std::span<const double> lower,
                               std::span<const double> upper, double later);

}  // namespace samara::codebooks
