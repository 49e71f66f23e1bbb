#pragma once

#include "samara/flow/grid/shape.h"
#include "samara/models/bodies/triangle_mesh.h"

namespace samara::flow {

/// A body in space from a closed mesh, moved so that the middle of its box is the origin and scaled so that its
/// longest extent is 1. Distances are those to the nearest triangle, found in a tree of boxes; their sign is that of
/// the normal at the nearest point, of edges and corners the mean over their triangles by angle (J. Baerentzen,
/// H. Aanaes, IEEE Trans. Vis. Comput. Graphics 11 (2005) 243).
/// @param thickness where it is thinnest, in such lengths: a mesh does not say
/// @throws ArgumentError if the mesh is not closed (models::require_closed), or the thickness not in (0, 1]
Shape mesh_shape(const models::TriangleMesh& mesh, double thickness);

}  // namespace samara::flow
