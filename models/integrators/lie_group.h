#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/integrators/integrate.h"

/// Motion of a rigid body on the group of rigid motions SE(3), for a body with any constant 6x6 inertia I
/// (its own and that of the fluid it moves), Kirchhoff's equations:
///
///   mu = I (u, w),   d/dt P = P x w + F,   d/dt L = L x w + P x u + T,   mu = (P, L)
///
/// A step of length h turns and shifts the body by exp(h xi) of one twist xi = (u, w), and carries the
/// momentum along: in the world it changes by the impulse of the wrench alone, taken half-way. xi is I^-1 of
/// the mean of the momenta before and after, found by fixed-point iteration. Then, to round-off and for every
/// step length,
///
///   - the attitude is a rotation,
///   - without wrench the momentum in the world, linear and angular, and the energy are constant,
///   - with one, the energy changes by h xi . (F, T): the work done.
///
/// The method is symmetric and of order two; a symmetric composition of five of its steps (M. Suzuki, Phys.
/// Lett. A 146, 1990, 319-323) is of order four and keeps all of this. Reference: J. C. Simo, K. K. Wong,
/// Unconditionally stable algorithms for rigid body dynamics that exactly preserve energy and momentum, Int.
/// J. Numer. Meth. Engng 31 (1991) 19-52, here on SE(3); E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
/// Integration, 2nd ed. (2006), IV.8 and VII.5.
///
///   const LieGroupIntegrator body(inertia, {.step = 0.01});
///   const BodyTrajectory trajectory = body({.v_WB_B = {1, 1, 1}, .w_WB_B = {1, 1, 1}}, times);
namespace samara::models {

/// Where a body is and how it moves. SI; W world, B body, Bo its origin.
struct BodyMotion {
  std::array<double, 4> q_WB = {1.0, 0.0, 0.0, 0.0};   ///< attitude (w, x, y, z), body to world
  Eigen::Vector3d p_WoBo_W = Eigen::Vector3d::Zero();  ///< position of the origin
  Eigen::Vector3d v_WB_B = Eigen::Vector3d::Zero();    ///< velocity of the origin, body axes: u
  Eigen::Vector3d w_WB_B = Eigen::Vector3d::Zero();    ///< angular velocity, body axes: w

  /// The rotation matrix of q_WB, orthonormal to round-off if |q_WB| = 1 is.
  Eigen::Matrix3d R_WB() const;
};

/// Force and torque about the body's origin, body axes [N, N m]; `power` is not used.
using BodyWrench = std::function<Wrench(double t, const BodyMotion& motion)>;

struct LieGroupOptions {
  /// Upper bound of the step [s]. Between two times asked for, steps are equal and end exactly on them.
  double step = 1e-2;
  int order = 2;             ///< 2, or 4 at five times the work
  int max_iterations = 100;  ///< of the fixed-point iteration of a step
  /// Most steps of the whole trajectory; it stops at the last time asked for that they reach.
  long max_steps = 100000000;
};

struct BodyTrajectory {
  /// done, too_many_steps, not_finite, or failed: the iteration of a step did not converge
  IntegrateStatus status = IntegrateStatus::failed;
  std::string message;
  double reached = 0.0;             ///< time of the last motion
  Eigen::VectorXd times;            ///< as asked for
  std::vector<BodyMotion> motions;  ///< one per time reached
  long steps = 0;
  long iterations = 0;  ///< of all steps: evaluations of the wrench

  bool is_usable() const { return status == IntegrateStatus::done; }
};

/// Immutable; may be shared between threads if the wrench may be called from them.
class LieGroupIntegrator {
 public:
  /// @param inertia 6x6, symmetric and positive definite: velocities (u, w) to impulses (P, L)
  /// @throws ArgumentError if the inertia or an option is outside its meaning.
  explicit LieGroupIntegrator(const Eigen::Ref<const Eigen::MatrixXd>& inertia,
                              const LieGroupOptions& options = {}, BodyWrench wrench = {});

  /// @param start motion at t = 0; its quaternion is normalised
  /// @param times not decreasing, from 0 on
  /// @throws ArgumentError if a number is not finite, the quaternion is zero, or times decrease. What the
  ///   wrench throws passes through.
  BodyTrajectory operator()(const BodyMotion& start, std::span<const double> times) const;

  /// 1/2 (u, w) . I (u, w) [J]
  double kinetic_energy(const BodyMotion& motion) const;
  /// R P [N s]
  Eigen::Vector3d world_impulse(const BodyMotion& motion) const;
  /// R L + x x R P [N m s], about the origin of the world
  Eigen::Vector3d world_angular_impulse(const BodyMotion& motion) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace samara::models
