#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include <unistd.h>

#include "samara/base/errors.h"
#include "samara/identification/captures/capture_file.h"

/// A new directory for the files of one test, removed with them at the end of its scope.
class TestFiles {
 public:
  TestFiles() {
    std::string name = (std::filesystem::temp_directory_path() / "samara-identification-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error(name);
    path_ = name;
  }
  TestFiles(const TestFiles&) = delete;
  TestFiles& operator=(const TestFiles&) = delete;
  ~TestFiles() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  const std::filesystem::path& path() const { return path_; }

  /// Writes a file and returns its path.
  std::filesystem::path put(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

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
