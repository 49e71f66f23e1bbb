#pragma once

#include <span>
#include <string>
#include <vector>

namespace samara::apps {

/// The files that reading captures reads, those that sidecars name among them: no output may be one of them.
/// @param sidecar of all tables; may be empty
/// @throws InputError for a sidecar that cannot be read
std::vector<std::string> files_of_captures(std::span<const std::string> captures,
                                           const std::string& sidecar = {});

}  // namespace samara::apps
