#pragma once

#include <vector>

#include <Eigen/Core>

/// Angles and attitudes without jumps.
namespace samara::identification {

/// The angles plus multiples of the period, such that each is nearest to where its predecessors lead (their
/// median rate). The first seen angle stays as it is; NaN stays.
/// @throws ArgumentError if `period` is not positive, or sizes do not match.
Eigen::VectorXd unwrapped(const Eigen::VectorXd& times, const Eigen::VectorXd& angles, double period);

/// Rotations of the body after which it looks as before, as unit quaternions (w, x, y, z), the identity not
/// among them: q and q * g (body to world) cannot be told apart.
using BodySymmetries = std::vector<Eigen::Vector4d>;

/// Half turns about the three body axes: a rectangular plate whose sides look alike.
BodySymmetries half_turns();

/// Unit quaternions of the same looks whose sign and whose symmetry are nearest to where their predecessors
/// lead. The first seen one is only normalised; NaN stays.
/// @throws ArgumentError if sizes do not match, or a quaternion is 0.
Eigen::MatrixX4d continuous_attitudes(const Eigen::VectorXd& times, const Eigen::MatrixX4d& quaternions,
                                      const BodySymmetries& symmetries = {});

}  // namespace samara::identification
