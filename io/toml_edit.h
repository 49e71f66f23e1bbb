#pragma once

#include <string>
#include <vector>

namespace samara::io {

/// A key of a table put in place of what a TOML text says.
struct TomlChange {
  std::string table;  ///< of the root, "fixed"
  std::string key;
  std::string value;  ///< as TOML; empty: the key goes
};

/// The text with the changes, one after the other, and everything else as it stands: comments, order, lines. A table
/// that is missing is added at the end.
/// @param name stands for the file in messages
/// @throws InputError if the text is no TOML; ArgumentError for a key that does not stand alone on lines of its own,
/// as in `fixed = { a = 1 }`, which cannot be changed so
std::string changed_toml(const std::string& text, const std::string& name,
                         const std::vector<TomlChange>& changes);

/// A key as TOML has it: bare, or in quotes where it holds other signs, as "v(0)" does.
std::string toml_key(const std::string& key);

}  // namespace samara::io
