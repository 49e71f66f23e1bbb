#pragma once

#include "samara/codebooks/plan/plan.h"
#include "samara/io/toml_document.h"

namespace samara::codebooks {

/// The table [body]: parameters of the body of which [fixed] and [box] say nothing are fixed by it.
/// @throws InputError with file and line for a plan of another model, without a reader, and for what describes no body
void read_body(const io::TomlTable& root, const BodyReader& body_reader, Plan& plan);

}  // namespace samara::codebooks
