#pragma once

#include <filesystem>

#include "samara/motion/sweeps/sweep.h"

/// Sweeps as HDF5 files, "samara-sweep" 0.1: plain groups and datasets, see docs/reference/sweep.md.
namespace samara::motion {

/// @throws ArgumentError if the file cannot be written.
void save(const Sweep& sweep, const std::filesystem::path& path);

/// The same file, marked as what is replaced and removed by a sweep that goes on from it: a result is not.
void save_checkpoint(const Sweep& sweep, const std::filesystem::path& path);

/// A checkpoint is read as well. @throws InputError for a file that is no sweep, damaged, or of a newer major version.
Sweep load_sweep(const std::filesystem::path& path);

/// Whether the file says that it is a sweep; a path that cannot be read is none.
bool is_sweep(const std::filesystem::path& path);

/// Whether a file has the mark of save_checkpoint(), also if it is damaged.
bool is_sweep_checkpoint(const std::filesystem::path& file);

}  // namespace samara::motion
