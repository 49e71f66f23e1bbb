#pragma once

#include <Eigen/Core>

namespace samara::motion {

/// Minimum of 1/2 z.H z - g.z within lower <= z <= upper, by an active set of bounds (C. L. Lawson, R. J. Hanson,
/// Solving Least Squares Problems, 1974, ch. 23; P. B. Stark, R. L. Parker, Bounded-variable least-squares, Comput.
/// Stat. 10 (1995)). For a few dozen variables.
/// @param H symmetric, positive definite  @param start within the bounds
Eigen::VectorXd bounded_minimum(const Eigen::MatrixXd& H, const Eigen::VectorXd& g,
                                const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                                const Eigen::VectorXd& start);

}  // namespace samara::motion
