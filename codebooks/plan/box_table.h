#pragma once

#include <string>

#include "samara/codebooks/plan/plan.h"
#include "samara/io/toml_document.h"

/// Internal to codebooks/: the keys of an entry of the table [box], read, checked and written.
namespace samara::codebooks {

/// @param unit of the coordinate
/// @throws InputError with file and line for what is no interval, and an axis that cannot be
BoxEntry read_box_entry(const io::TomlTable& box, const std::string& key, const std::string& unit);

/// "{ range = [0, 1], nodes = 9 }", with what stands in the brackets as it is given.
std::string box_entry_text(const BoxEntry& entry, const std::string& lower, const std::string& upper);

}  // namespace samara::codebooks
