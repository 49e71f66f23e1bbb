#pragma once

#include <string>

#include "samara/identification/design/design.h"

namespace samara::identification {

/// One JSON object ("schema": "samara-design/1"), in SI units; numbers to the last bit, null for what there
/// is not.
std::string design_json(const Design& design);

/// Errors now and expected, releases, and which outputs and times matter, for people.
std::string design_text(const Design& design);

}  // namespace samara::identification
