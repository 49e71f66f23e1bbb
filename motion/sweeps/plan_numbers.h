#pragma once

#include <string>

#include "samara/io/toml_document.h"

/// Internal to motion/: numbers of plans.
namespace samara::motion {

/// @returns the value
/// @throws InputError at the key for a number too large to calculate with, or NaN
double in_size(const io::TomlTable& table, const std::string& key, double value);

}  // namespace samara::motion
