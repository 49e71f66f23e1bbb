#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

/// Reading whole text files: plans, configs, sidecars, tables.
namespace samara::io {

/// What a file may ask of its reader.
struct TextLimits {
  std::size_t bytes = std::size_t{256} << 20;
  /// How long a pipe or terminal may keep silent [s].
  double silence = 60.0;
};

/// The whole content of a file. Pipes (`/dev/stdin`, `<(program)`) and devices are read to their end, which
/// must come within the limits.
/// @throws InputError naming the path if it does not exist, is a directory, cannot be read, is larger than
/// `limits.bytes`, or keeps silent for longer than `limits.silence`.
std::string read_text_file(const std::filesystem::path& path, const TextLimits& limits = {});

}  // namespace samara::io
