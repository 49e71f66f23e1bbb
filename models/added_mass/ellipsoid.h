#pragma once

#include <Eigen/Core>

/// Added mass of an ellipsoid in an unbounded ideal fluid.
///
/// A body that accelerates through a fluid accelerates fluid as well; the kinetic energy of that fluid is
/// 1/2 (u.M u + w.J w) with u the velocity of the centre and w the angular velocity. In the axes of an
/// ellipsoid both M and J are diagonal (G. Green, 1833; H. Lamb, Hydrodynamics, 6th ed., 1932, art. 114 and
/// 124), with the integrals A, B, C of the shape:
///
///   M_x = m_f A/(2-A),   J_x = m_f/5 (b^2-c^2)^2 (C-B) / (2(b^2-c^2) + (b^2+c^2)(B-C)),   and cyclically,
///
/// m_f = 4/3 pi fluid_density abc the mass of the displaced fluid. They are evaluated in a form that does not
/// cancel: relative errors stay below 1e-13 at every aspect ratio, for axes in any order.
///
///   const DiagonalAddedMass leaf = ellipsoid_added_mass({0.073, 0.042, 0.0003}, 1.2);
namespace samara::models {

/// Added mass in axes in which it is diagonal, about the centre.
struct DiagonalAddedMass {
  Eigen::Vector3d mass = Eigen::Vector3d::Zero();     ///< M_x, M_y, M_z [kg]
  Eigen::Vector3d inertia = Eigen::Vector3d::Zero();  ///< J_x, J_y, J_z [kg m^2]

  /// The same as a 6x6 matrix, linear motions first.
  Eigen::Matrix<double, 6, 6> matrix() const;
};

/// The integrals A, B, C above (dimensionless, in sum 2), for semi-axes [m] in any order.
/// @throws ArgumentError if a semi-axis is not a positive number.
Eigen::Vector3d ellipsoid_shape_integrals(const Eigen::Vector3d& semi_axes);

/// Added mass of an ellipsoid with the given semi-axes [m] along x, y, z in a fluid of density
/// `fluid_density` [kg/m^3].
/// @throws ArgumentError if a semi-axis or the density is not a positive number, or if they are so far apart
/// (a million million millions) that the result leaves the range of doubles.
DiagonalAddedMass ellipsoid_added_mass(const Eigen::Vector3d& semi_axes, double fluid_density);

}  // namespace samara::models
