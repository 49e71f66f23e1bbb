#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

/// Internal to identification/.
namespace samara::identification {

/// The Hessian of a cost: J^T W J, and what that lacks where residuals are large, learned from the steps
/// taken by the update of J. E. Dennis, D. M. Gay and R. E. Welsch, ACM Trans. Math. Softw. 7 (1981) 348-368,
/// section 4 (there S, with its sizing).
class SecantModel {
 public:
  /// At a new point; what was learned stays.
  void move_to(Eigen::MatrixXd normal);
  /// After move_to(). A change that J^T W J is no guide to makes it forget.
  /// @param change of the gradient along the step
  void learn(const Eigen::VectorXd& step, const Eigen::VectorXd& change);
  void forget() { learned_.setZero(); }
  bool has_learned() const { return (learned_.array() != 0.0).any(); }

  const Eigen::MatrixXd& normal() const { return normal_; }
  Eigen::MatrixXd hessian() const { return normal_ + learned_; }

 private:
  Eigen::MatrixXd normal_, learned_;
};

/// -(matrix + damping * diagonal)^-1 gradient on the free directions, zero on the others.
/// @param diagonal positive, of the whole matrix
/// @returns nothing if the damped matrix is not positive
std::optional<Eigen::VectorXd> damped_step(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& diagonal,
                                           const Eigen::VectorXd& gradient, const std::vector<int>& free,
                                           double damping);

/// The diagonal by which damping is measured: that of `normal`, but no entry next to zero.
Eigen::VectorXd damping_scale(const Eigen::MatrixXd& normal);

}  // namespace samara::identification
