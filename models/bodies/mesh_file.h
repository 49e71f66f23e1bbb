#pragma once

#include <string>

#include "samara/models/bodies/triangle_mesh.h"

/// Triangle meshes from files: OBJ, STL (text or binary), PLY, told apart by their ending. In a library of
/// its own (link samara::mesh_files): what reads the formats, assimp, takes longer to load than the rest of
/// Samara.
namespace samara::models {

struct MeshFileOptions {
  /// Corners nearer to each other than this times the mesh's size are one corner: STL lists the corners of
  /// each triangle anew, and files carry them with about seven digits. Triangles that lose their area by this
  /// are dropped.
  double merge_tolerance = 1e-6;
  /// Turn the surface over if it is inside out, instead of refusing it.
  bool turn_outward = false;
  /// Refuse what encloses no volume. Without it, open surfaces are taken, too: they are good for pictures only.
  bool closed = true;
};

/// A mesh [m] from a file, closed unless the options say otherwise.
/// @param metres_per_unit what one unit of the file means: such files carry no unit. 1e-3 for millimetres.
/// @throws InputError if the file cannot be read, has another ending, holds no triangles or a coordinate that
///   is not finite, or is not closed (require_closed, with the place in metres).
/// @throws ArgumentError if metres_per_unit is not a positive number, or the tolerance is not in [0, 0.1], or
///   above 0 and below 2^-53.
TriangleMesh read_mesh(const std::string& path, double metres_per_unit, const MeshFileOptions& options = {});

}  // namespace samara::models
