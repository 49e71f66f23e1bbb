#pragma once

#include <filesystem>
#include <string>

#include "samara/codebooks/book/codebook.h"

/// Codebooks as flat files: what an evaluator needs and nothing else, ready to be used as it lies in memory. The C
/// header codebooks/capi/samara_eval.h reads them without any library; docs/flat_file.md has the format.
namespace samara::codebooks {

/// The bytes of the file. Kept are fields, axes, pieces, names, units, values held, the largest errors
/// of the certificate and the length of an attitude; not what is derived from states, meshes,
/// provenance and the text of the plan.
/// @throws InputError if a piece of a large file is damaged; ArgumentError where a coordinate is counted from a front
std::string format_flat(const Codebook& book);

/// The same into a file, at once. @throws ArgumentError also if it cannot be written
void save_flat(const Codebook& book, const std::filesystem::path& path);

}  // namespace samara::codebooks
