#include "samara/io/file_lock.h"

#include <array>
#include <cerrno>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "samara/base/errors.h"

namespace samara::io {

namespace {

/// Whether the path still leads to the open file: another holder may have removed it in between.
bool is_at(const std::filesystem::path& path, int file) {
  struct stat open = {}, there = {};
  return ::fstat(file, &open) == 0 && ::stat(path.c_str(), &there) == 0 && open.st_ino == there.st_ino &&
         open.st_dev == there.st_dev;
}

/// What the holder wrote into it.
std::string holder_of(int file) {
  std::array<char, 32> text = {};
  const ssize_t size = ::pread(file, text.data(), text.size(), 0);
  return size > 0 ? fmt::format("process {}", std::string(text.data(), static_cast<std::size_t>(size)))
                  : "another process";
}

/// Whether it holds what no lock does: a lock has the number of a process, or nothing yet.
bool is_of_others(int file) {
  std::array<char, 64> text = {};
  const ssize_t size = ::pread(file, text.data(), text.size(), 0);
  constexpr std::string_view kOfLocks = "0123456789 \t\r\n";
  return size == std::ssize(text) ||
         (size > 0 &&
          std::string_view(text.data(), static_cast<std::size_t>(size)).find_first_not_of(kOfLocks) !=
              std::string_view::npos);
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& path, const std::string& purpose) : path_(path) {
  do {
    file_ = std::make_unique<Descriptor>(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
    if (!file_->valid()) return;
    if (is_of_others(file_->get()))
      throw ArgumentError(
          fmt::format("the file \"{}\" is in the way: it is no lock of samara", path.string()));
    int problem = EINTR;
    while (problem == EINTR) problem = ::flock(file_->get(), LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
    if (problem == EWOULDBLOCK)
      throw ArgumentError(fmt::format("{} {} already ({} is its lock), expected one at a time",
                                      holder_of(file_->get()), purpose, path.string()));
    if (problem != 0) return;  // a file system without locks, where nobody holds any
  } while (!is_at(path, file_->get()));
  const std::string own = fmt::format("{}", ::getpid());
  // Only for the message to others.
  if (::ftruncate(file_->get(), 0) != 0 || ::pwrite(file_->get(), own.data(), own.size(), 0) < 0) errno = 0;
}

FileLock::~FileLock() {
  if (!file_->valid()) return;
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace samara::io
