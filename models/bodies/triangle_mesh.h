#pragma once

#include <Eigen/Core>

/// Closed surfaces made of triangles.
namespace samara::models {

/// Corners and triangles. The triangles must enclose a volume without gaps, each with its corners
/// counter-clockwise seen from outside.
struct TriangleMesh {
  Eigen::Matrix3Xd vertices;   ///< one column per corner [m]
  Eigen::Matrix3Xi triangles;  ///< one column per triangle: indices of its corners
};

/// Volume [m^3] by the divergence theorem: negative if the surface is inside out. Does not check.
double enclosed_volume(const TriangleMesh& mesh);

/// The same surface with all triangles turned over if it is inside out.
TriangleMesh oriented_outward(TriangleMesh mesh);

/// The same surface in at least that many triangles: the longest side of all is halved, and with it the two triangles
/// that it belongs to, again and again. Facets stay flat, and long thin triangles become shorter ones first.
/// @param mesh closed (require_closed)
TriangleMesh divided(TriangleMesh mesh, int triangles);

/// Refuses what encloses no volume.
///
/// A separate part may be inside out as the wall of a cavity: its bounding box must lie within that of a part
/// that is not. What is not checked: whether the surface cuts through itself, or parts overlap.
/// @throws ArgumentError, naming the place, if there are no triangles, a coordinate is not finite, an index
/// is out of range, a corner belongs to no triangle, a triangle has no area (its height is below 1e-12 of the
///   mesh's size), an edge is not shared by exactly two triangles (the surface is open, or folds onto
///   itself), two neighbours have opposite orientation, the volume vanishes, or the surface or a separate
///   part of it is inside out.
void require_closed(const TriangleMesh& mesh);

}  // namespace samara::models
