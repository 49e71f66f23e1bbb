#pragma once

#include <filesystem>
#include <vector>

/// The file of a PEtab problem, which names its tables; internal to identification/.
namespace samara::identification {

struct PetabFile {
  std::filesystem::path file = {};
  std::vector<std::filesystem::path> parameters = {};  ///< one
  std::vector<std::filesystem::path> conditions = {};
  std::vector<std::filesystem::path> observables = {};
  std::vector<std::filesystem::path> measurements = {};
  std::vector<std::filesystem::path> models = {};  ///< not read: the model is named in the call

  /// All that is read.
  std::vector<std::filesystem::path> files() const;
};

/// Whether a path has the ending of such a file, .yaml or .yml.
bool is_petab_file(const std::filesystem::path& path);

/// Of YAML what such files use: `key: value`, `key: [a, b]`, and lists of `- item`; one problem.
/// @throws InputError with file and line for anything else, another version than 1, and for a table that is missing
PetabFile read_petab_file(const std::filesystem::path& path);

}  // namespace samara::identification
