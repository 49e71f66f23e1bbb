#pragma once

#include <filesystem>
#include <memory>

#include "samara/io/descriptor.h"

namespace samara::io {

/// A lock between processes, held as long as the object lives, and given back by the system if the process dies. The
/// file of the lock stays where a process was killed; the next one takes it over.
class FileLock {
 public:
  /// @param path of the file of the lock, which is removed at the end
  /// @param purpose of it, for the message: "builds book.h5"
  /// @throws ArgumentError if another process holds it, naming the process, or if what is there is no lock: an empty
  ///   file is none, nor is a link. Where the file cannot be made (a name that is too long), or its file system knows
  ///   no locks, there is no lock.
  FileLock(const std::filesystem::path& path, const std::string& purpose);
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

 private:
  std::filesystem::path path_;
  std::unique_ptr<Descriptor> file_;
};

}  // namespace samara::io
