#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/bodies/triangle_mesh.h"

/// Rigid bodies of uniform density, as the models of moving bodies need them.
///
/// A body is described in a frame of its own: a shape given by sizes about its centre along x, y, z, a mesh
/// in the axes of the mesh. Its body axes start at the centre of mass along the principal axes of inertia,
/// the longest extent (smallest moment) first, so that the normal of a plate or leaf is body z.
///
///   const Body leaf = mesh_body(read_mesh("leaf.stl", 1e-3), 700.0);
///   const DiagonalAddedMass K = ellipsoid_added_mass(leaf.proxy_semi_axes, 1.2);
namespace samara::models {

/// Principal axes of a symmetric matrix of inertia.
struct PrincipalAxes {
  /// Columns: body x, y, z; a proper rotation, body axes to the frame of the matrix.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();  ///< in ascending order
};

/// Principal axes and moments, in an order and with signs that depend on the matrix alone: moments ascend;
/// among directions of equal moments (within 1e-9 of the largest) those next to the frame's axes are taken;
/// the first two axes have their largest component positive, the third completes a right-handed frame.
/// @throws ArgumentError if the matrix is not finite or not symmetric (to 1e-9 of its largest entry).
PrincipalAxes principal_axes(const Eigen::Matrix3d& inertia);

struct Body {
  double density = 0.0;                                      ///< of the solid [kg/m^3]
  double volume = 0.0;                                       ///< [m^3]
  double mass = 0.0;                                         ///< [kg]
  Eigen::Vector3d centre_of_mass = Eigen::Vector3d::Zero();  ///< in the frame of the description [m]
  PrincipalAxes principal;  ///< body axes in that frame; moments about the centre of mass [kg m^2]
  /// Semi-axes [m] of the proxy ellipsoid: half the extents max(P.r) - min(P.r) of the body along each body
  /// axis r.
  Eigen::Vector3d proxy_semi_axes = Eigen::Vector3d::Zero();
};

// Densities in kg/m^3, lengths in m. All throw ArgumentError, naming the size, its value and the body, where
// one is not a positive number.

/// Semi-axes along x, y, z.
Body ellipsoid_body(const Eigen::Vector3d& semi_axes, double density);
/// Circular disc (cylinder of full height `thickness`) about z.
Body disc_body(double radius, double thickness, double density);
/// Rectangular plate: full sides along x, y, z.
Body plate_body(const Eigen::Vector3d& sides, double density);
/// The solid that a closed mesh encloses. Volume, centre and moments are exact integrals over the polyhedron,
/// by the divergence theorem (B. Mirtich, Fast and accurate computation of polyhedral mass properties, J.
/// Graphics Tools 1 (1996) 31-50), moments taken about the centre at once so that a mesh far from its origin
/// loses no digits.
/// @throws ArgumentError also if the mesh is not closed (require_closed).
Body mesh_body(const TriangleMesh& mesh, double density);

/// Warnings of what looks like a mistake of units in a body or a fluid, one sentence each. Solids
/// below 20 kg/m^3, fluids between 5 and 500 kg/m^3 or below 0.05 or above 2e4, extents above 10 m or below
/// 1e-5 m.
std::vector<std::string> unit_warnings(const Body& body, double fluid_density);

}  // namespace samara::models
