#pragma once

#include <filesystem>

#include "samara/codebooks/book/codebook.h"

namespace samara::codebooks {

/// Writes to a temporary name beside `path`, flushes, renames: a killed process leaves no broken file.
/// @throws ArgumentError if the file cannot be written.
void save(const Codebook& book, const std::filesystem::path& path);

}  // namespace samara::codebooks
