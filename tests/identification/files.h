#pragma once

#include <exception>
#include <filesystem>
#include <string>

#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/identification/captures/capture_file.h"

/// What an expected error says, without the directory of its file; where there was none, or one of another
/// kind, the text says that instead.
template <typename Expected, typename Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const Expected& error) {
    const std::string text = error.what();
    const std::string directory = std::filesystem::temp_directory_path().string();
    if (!text.starts_with(directory)) return text;
    return text.substr(text.find('/', directory.size() + 1) + 1);
  } catch (const std::exception& error) {
    return std::string("an exception of another kind: ") + error.what();
  }
  return "no exception";
}

inline std::string reading_error(const std::filesystem::path& path) {
  return error_of<samara::InputError>([&] { samara::identification::read_captures(path); });
}
