#pragma once

#include <string>

#include "air/cloud_output.h"
#include "samara/models/bodies/triangle_mesh.h"

/// The flights of a cloud of realisations as a file for viewers: a node each.
namespace samara::apps {

/// Writes the trajectories that the cloud keeps to a .glb or .usda, keys at its frames, each to where it ends, and at
/// its landing. Warns of flights without two frames, which are left out, and where frames are so far apart that players
/// draw another motion.
/// @throws ArgumentError if the model moves no body; NoResultError if no flight has two frames
void write_cloud_animation(const std::string& path, const CloudFile& file, const models::TriangleMesh& body);

}  // namespace samara::apps
