#pragma once

#include <string>

namespace samara::apps {

/// Version, commit, format of codebooks, options of the build and licence of the whole.
std::string version_text();

}  // namespace samara::apps
