#pragma once

#include "samara/codebooks/plan/plan.h"
#include "samara/io/toml_document.h"

namespace samara::codebooks {

/// The table [command] of a plan.
/// @throws InputError with file and line for unknown keys, an empty call, names that are taken or cannot name
/// a column, units that are not of the SI, and limits out of range.
PlannedCommand read_command(const io::TomlTable& table);

}  // namespace samara::codebooks
