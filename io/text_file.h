#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

/// Reading whole text files: plans, configs, sidecars, tables.
namespace samara::io {

/// What some programs begin a text in UTF-8 with.
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// What a file may ask of its reader.
struct TextLimits {
  std::size_t bytes = std::size_t{256} << 20;
  /// How long a pipe or terminal may send nothing [s].
  double silence = 60.0;
  /// What the file should be: "a plan". Where it is said, a file that has a binary_kind() is refused by that.
  std::string expected = "";
};

/// What a file that begins so is, if it is none of text: "a PNG picture", "a JPEG picture", "an archive (zip, npz)".
/// Empty for all others.
std::string binary_kind(std::string_view beginning);

/// The whole content of a file. Pipes (`/dev/stdin`, `<(program)`) and devices are read to their end, which
/// must come within the limits.
/// @throws InputError naming the path if it does not exist, is a directory, cannot be read, has a binary_kind(), is
/// larger than `limits.bytes`, or sends nothing for longer than `limits.silence`.
std::string read_text_file(const std::filesystem::path& path, const TextLimits& limits = {});

}  // namespace samara::io
