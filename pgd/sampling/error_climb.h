#pragma once

#include <functional>

#include <Eigen/Core>

/// Looking for the largest error of a field where a few of its errors do not fit the others.
///
/// A narrow feature that nobody has called yet shows at its tails first: errors that are small, and yet far
/// above all others. From there climbs lead to where the field is most wrong.
namespace samara::pgd {

/// Errors (at least 0) at points, coordinates x points.
using ErrorsAt = std::function<Eigen::VectorXd(const Eigen::MatrixXd& points)>;

/// Whether the largest error is more than so many times the 95 % quantile. Errors of smooth functions differ
/// from place to place by factors of two to five.
bool has_outliers(const Eigen::VectorXd& errors, double times);

struct Climbs {
  Eigen::MatrixXd points;  ///< ends, coordinates x climbs
  Eigen::VectorXd errors;  ///< there, never less than at the start
};

/// Climbs on the logarithm of the error, all at the same time: in every step points on both sides along every
/// coordinate give slope and curvature, and points along Newton's direction and the steepest one are tried.
/// About 2 d + 8 calls a step and climb, ten steps at most.
/// @param lower, upper box of the climbs; coordinates without width stay
/// @param starts coordinates x climbs  @param errors at the starts
Climbs climb_errors(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper, const ErrorsAt& errors_at,
                    const Eigen::MatrixXd& starts, const Eigen::VectorXd& errors);

/// Climbs from the `count` points with the largest errors.
Climbs climb_from_worst(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper, const ErrorsAt& errors_at,
                        const Eigen::MatrixXd& points, const Eigen::VectorXd& errors, int count);

}  // namespace samara::pgd
