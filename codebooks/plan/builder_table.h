#pragma once

#include <string>

#include "samara/codebooks/plan/plan.h"
#include "samara/io/toml_document.h"

/// Internal to codebooks/: the keys of the table [builder], read, checked and written.
namespace samara::codebooks {

/// The table [builder], once the plan knows what it is about and its box.
/// @throws InputError with file and line for unknown keys, numbers out of range, and what the builder of such a plan
/// does not take
void read_builder(const io::TomlTable& root, Plan& plan);

std::string builder_text(const BuildRequest::Builder& builder);

}  // namespace samara::codebooks
