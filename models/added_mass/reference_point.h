#pragma once

#include <Eigen/Core>

namespace samara::models {

/// The added mass of a body about another point: `offset` [m] leads from the old point to the new one, in
/// body axes. The matrix acts on (u, w), linear velocity first. With A = [[1, [offset]x], [0, 1]], which
/// takes velocities of the new point to those of the old one (u = u' + offset x w), it is A^T K A.
Eigen::Matrix<double, 6, 6> added_mass_about(const Eigen::Matrix<double, 6, 6>& added_mass,
                                             const Eigen::Vector3d& offset);

}  // namespace samara::models
