#pragma once

#include <filesystem>

#include "samara/codebooks/book/codebook.h"

/// The codebook file (HDF5), format "samara-codebook" version 0.4; docs/codebook_file.md describes every
/// dataset.
namespace samara::codebooks {

/// Writes to a temporary name beside `path`, flushes, renames: a killed process leaves no broken file.
/// @throws ArgumentError if the file cannot be written.
void save(const Codebook& book, const std::filesystem::path& path);

/// Of a file of more than 1 MiB and of several pieces none is read before it is first asked for: damage
/// there is found then, with the same error. Such a codebook keeps the file open.
/// @throws InputError naming file and dataset if it is missing, truncated, foreign, of another major format
/// version,
///   or holds values that cannot be.
Codebook load(const std::filesystem::path& path);

}  // namespace samara::codebooks
