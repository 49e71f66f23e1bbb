#include "samara/io/file_lock.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>

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

/// Whether it holds what no lock does: a lock is the number of a process, from its first write on. An empty file is of
/// others, who may mark by it that they are at work. One of ours is empty only where its process was killed, or found
/// no room on the disk, right after it had made the file: then whoever reads the message has to remove it.
bool is_of_others(int file) {
  std::array<char, 64> text = {};
  const ssize_t size = ::pread(file, text.data(), text.size(), 0);
  return size <= 0 || size == std::ssize(text) ||
         std::string_view(text.data(), static_cast<std::size_t>(size)).find_first_not_of("0123456789") !=
             std::string_view::npos;
}

/// Empty: perhaps another process has just made it, and writes its number next.
bool is_being_made(int file) {
  char first = 0;
  return ::pread(file, &first, 1, 0) == 0;
}
constexpr int kMostLooks = 20;
constexpr std::chrono::milliseconds kBetweenLooks(5);

/// Of this process, over another that stands there, so that the file is never empty. Only for the message to others.
void write_number(int file) {
  const std::string own = fmt::format("{}", ::getpid());
  if (::pwrite(file, own.data(), own.size(), 0) < 0 || ::ftruncate(file, std::ssize(own)) != 0) errno = 0;
}

/// The file that is there, or a new one with our number, where nobody else has made one in between. Not valid where
/// there can be none.
/// @throws ArgumentError for a file, or a link, of others
std::unique_ptr<Descriptor> opened(const std::filesystem::path& path) {
  int looks = 0;
  while (true) {
    auto file = std::make_unique<Descriptor>(::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC));
    const int problem = file->valid() ? 0 : errno;
    const bool is_link = problem == ELOOP;  // some lock by links that lead nowhere
    if (file->valid() && is_being_made(file->get()) && ++looks < kMostLooks) {
      std::this_thread::sleep_for(kBetweenLooks);
      continue;
    }
    if (is_link || (file->valid() && is_of_others(file->get())))
      throw ArgumentError(
          fmt::format("the file \"{}\" is in the way: it is no lock of samara", path.string()));
    if (problem != ENOENT) return file;
    file = std::make_unique<Descriptor>(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
    if (file->valid()) write_number(file->get());
    if (file->valid() || errno != EEXIST) return file;
  }
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& path, const std::string& purpose) : path_(path) {
  do {
    file_ = opened(path);
    if (!file_->valid()) return;
    int problem = EINTR;
    while (problem == EINTR) problem = ::flock(file_->get(), LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
    if (problem == EWOULDBLOCK)
      throw ArgumentError(fmt::format("{} {} already ({} is its lock), expected one at a time",
                                      holder_of(file_->get()), purpose, path.string()));
    if (problem != 0) return;  // a file system without locks, where nobody holds any
  } while (!is_at(path, file_->get()));
  write_number(file_->get());
}

FileLock::~FileLock() {
  if (!file_->valid()) return;
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace samara::io
