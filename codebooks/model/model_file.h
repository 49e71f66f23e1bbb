#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "samara/io/toml_document.h"
#include "samara/models/equations/equation_model.h"

/// Models as text: [equations] of a plan, or a file of its own with the same keys at its root.
///
///     name = "predator_prey"                 # optional, as is title
///     states = { prey = { initial = 10 }, predator = { initial = 5 } }
///     parameters = { growth = { unit = "1/s", default = 1 }, hunt = { unit = "1/s", above = 0 } }
///     let = { meetings = "prey*predator" }   # optional: abbreviations, each may use those before it
///     rates = { prey = "growth*prey - hunt*meetings", predator = "hunt*meetings - growth*predator" }
namespace samara::codebooks {

/// @throws InputError at the key that is wrong
models::Equations read_equations(const io::TomlTable& table);

/// The model of such a table. @throws InputError at the key that is wrong
std::shared_ptr<const models::Model> read_equation_model(const io::TomlTable& table);

/// @throws InputError if the table takes the name of another model
void check_name(const io::TomlTable& table);

/// What read_equations() reads back.
std::string to_toml(const models::Equations& equations);

/// Text as a string of TOML.
std::string quoted_toml(const std::string& text);

/// A model by what a user calls it: one of the library's or of a loaded library's by its name, or a file
/// "model.toml", which may be a plan that holds its equations. @param folder that such a path is relative to
/// @throws ArgumentError where there is no model of that name; InputError for a file that holds none
std::shared_ptr<const models::Model> open_model(const std::string& name_or_file,
                                                const std::filesystem::path& folder = {});

/// Whether the text is taken for a file by open_model().
bool is_model_file(const std::string& name_or_file);

}  // namespace samara::codebooks
