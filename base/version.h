#pragma once

namespace samara {
/// The version of the library, "major.minor.patch".
const char* version();
}  // namespace samara
