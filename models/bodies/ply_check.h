#pragma once

#include <string>

namespace samara::models {

/// Whether a PLY file holds what its header announces. The library that reads it believes headers: it takes
/// memory for any count, and never stops looking for the end of a header, or for numbers after the end of a
/// text.
/// @throws InputError naming the header's fault, or the element at which a text ends
void require_complete_ply(const std::string& path);

}  // namespace samara::models
