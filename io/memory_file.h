#pragma once

#include <filesystem>
#include <string_view>

namespace samara::io {

/// Bytes as a file that lies in memory, for readers that want a file. It ends when this object and all who opened it
/// are gone.
class MemoryFile {
 public:
  /// @throws NoResultError with the system's reason if there is no room for them
  explicit MemoryFile(std::string_view bytes);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  /// To be opened as long as this object lives.
  const std::filesystem::path& path() const { return path_; }

 private:
  int descriptor_ = -1;
  std::filesystem::path path_;
};

}  // namespace samara::io
