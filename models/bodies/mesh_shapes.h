#pragma once

#include "samara/models/bodies/triangle_mesh.h"

/// Meshes of simple bodies, fine where potential flow needs it.
namespace samara::models {

enum class Placement {
  on_surface,    ///< corners on the ellipsoid: the mesh is inscribed, its volume a little smaller
  equal_volume,  ///< corners on a slightly larger similar ellipsoid: the mesh has the ellipsoid's volume
};

/// Ellipsoid with semi-axes a, b, c [m] along x, y, z, made for flat ones: rings about the z axis, at equal
/// steps of the polar angle of the sphere it is stretched from, so that they close up towards the rim z = 0;
/// ring k has `sectors` k corners. Triangles: 2 sectors rings^2.
/// @throws ArgumentError if a semi-axis is not a positive number, rings < 1 or sectors < 3.
TriangleMesh ellipsoid_mesh(const Eigen::Vector3d& semi_axes, int rings, int sectors = 6,
                            Placement placement = Placement::on_surface);

/// Ellipsoid stretched from a sphere that is divided evenly: the icosahedron, each edge divided into
/// `divisions`. Triangles: 20 divisions^2. @throws as above.
TriangleMesh icosahedral_ellipsoid_mesh(const Eigen::Vector3d& semi_axes, int divisions,
                                        Placement placement = Placement::on_surface);

/// Box with full sides [m] along x, y, z about the origin: nx, ny and nz cells along them, which shrink towards
/// the edges as Chebyshev points do. Triangles: 4 (nx ny + nz (nx + ny)).
/// @throws ArgumentError if a side is not a positive number or a number of cells is below 1.
TriangleMesh box_mesh(const Eigen::Vector3d& sides, int nx, int ny, int nz = 1);

}  // namespace samara::models
