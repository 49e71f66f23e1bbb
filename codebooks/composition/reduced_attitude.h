#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/model.h"

namespace samara::codebooks {

/// States of a body without what its motion does not depend on: the length of the quaternion, and, where the
/// model has the symmetry "rotation about z", the yaw.
///
/// An attitude is q = h s / f with the heading h = (qw, 0, 0, qz), a turn about the vertical and a length,
/// and the tilt
///
///   s = f/(qw^2 + qz^2) (qw^2 + qz^2, qw qx + qz qy, qw qy - qz qx, 0),
///
/// of which two numbers vary: f tan(angle/2) along the horizontal axis that tilts the body, the direction of
/// gravity in body axes seen from the opposite pole. Positions and vectors in world axes are turned back by
/// the same yaw. Without that symmetry (in a wind) only the length goes: h = (qw, 0, 0, 0), and s has three
/// numbers. Upside down (qw = qz = 0) there is no such s: towards it the numbers of s grow without bound. There the
/// same is done from upside down: h = (qx, 0, 0, qy) and s = (varies, f, 0, varies).
class ReducedAttitude {
 public:
  /// @param quaternion place of qw among the states  @param scale f, of the reduced quaternions
  ReducedAttitude(const models::ModelInfo& info, int quaternion, double scale, bool without_yaw,
                  bool is_upside_down = false);

  /// States that are the same in all reduced states: qw = f, and qz = 0 without yaw; upside down qx and qy.
  bool holds(int state) const {
    const int one = is_upside_down_ ? 1 : 0, none = is_upside_down_ ? 2 : 3;
    return state == quaternion_ + one || (without_yaw_ && state == quaternion_ + none);
  }

  /// Whether a state is a number of the quaternion.
  bool turns(int state) const { return state >= quaternion_ && state < quaternion_ + 4; }

  bool is_without_yaw() const { return without_yaw_; }

  /// @param by_x d(reduced)/dx, states x states; null: not wanted
  Eigen::VectorXd reduced(const Eigen::VectorXd& x, Eigen::MatrixXd* by_x) const;

  /// A later reduced state y, with heading and length of x put back.
  /// @param by_y, by_x derivatives, states x states; both or none
  Eigen::VectorXd restored(const Eigen::VectorXd& y, const Eigen::VectorXd& x, Eigen::MatrixXd* by_y,
                           Eigen::MatrixXd* by_x) const;

 private:
  /// Cosine and sine of the yaw, and their derivatives by qw and qz.
  struct Turn {
    double c = 1.0, s = 0.0;
    Eigen::Vector2d dc = Eigen::Vector2d::Zero(), ds = Eigen::Vector2d::Zero();
  };
  Turn turn(const Eigen::VectorXd& x) const;
  Eigen::VectorXd reduced_upright(const Eigen::VectorXd& x, Eigen::MatrixXd* by_x) const;
  Eigen::VectorXd restored_upright(const Eigen::VectorXd& y, const Eigen::VectorXd& x, Eigen::MatrixXd* by_y,
                                   Eigen::MatrixXd* by_x) const;
  /// The quaternion (qx, -qw, -qz, qy), q times -i: upright where q is upside down; and back.
  Eigen::VectorXd turned_over(Eigen::VectorXd x) const;
  Eigen::VectorXd turned_back(Eigen::VectorXd x) const;
  /// Of a map between quaternions that are turned over, that between those which are not.
  void turn_back(Eigen::MatrixXd* slopes) const;

  int quaternion_;
  double scale_;
  bool without_yaw_, is_upside_down_;
  std::vector<int> vectors_;  ///< places of the first of positions and vectors in world axes
};

}  // namespace samara::codebooks
