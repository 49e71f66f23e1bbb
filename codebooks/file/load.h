#pragma once

#include <filesystem>
#include <string_view>

#include "samara/codebooks/book/codebook.h"

namespace samara::codebooks {

/// Of a file of more than 1 MiB and of several pieces none is read before it is first asked for: damage
/// there is found then, with the same error. Such a codebook keeps the file open.
/// @throws InputError naming file and dataset if it is missing, truncated, foreign, of another major format
///   version, or holds impossible values.
Codebook load(const std::filesystem::path& path);

/// The same of the bytes of such a file, which need not stay: all pieces are read at once. Errors name "bytes in
/// memory".
/// @throws InputError as load(), NoResultError if memory is short
Codebook load_bytes(std::string_view bytes);

/// Whether the file says that it is a codebook, sound or not.
bool is_codebook(const std::filesystem::path& path);

}  // namespace samara::codebooks
