#pragma once

#include <filesystem>

#include "samara/motion/database/motion_graph.h"

/// Databases of motions as HDF5 files, "samara-motions" 0.1: plain groups and datasets, see docs/motion.md.
namespace samara::motion {

/// With its graph and the counts of its chain, for other readers; both are made anew from the segments when it is read.
/// @throws ArgumentError if the file cannot be written.
void save(const MotionDatabase& database, const MotionGraph& graph, const std::filesystem::path& path);

/// @throws InputError for a file that is no database of motions, damaged, or of a newer major version.
MotionDatabase load_database(const std::filesystem::path& path);

}  // namespace samara::motion
