#pragma once

#include <filesystem>

#include "samara/motion/sweeps/sweep.h"

/// Sweeps as HDF5 files, "samara-sweep" 0.1: plain groups and datasets, see docs/reference/sweep.md.
namespace samara::motion {

/// @throws ArgumentError if the file cannot be written.
void save(const Sweep& sweep, const std::filesystem::path& path);

/// @throws InputError for a file that is no sweep, damaged, or of a newer major version.
Sweep load_sweep(const std::filesystem::path& path);

/// Whether the file says that it is a sweep; a path that cannot be read is none.
bool is_sweep(const std::filesystem::path& path);

}  // namespace samara::motion
