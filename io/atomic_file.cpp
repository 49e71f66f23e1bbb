#include "samara/io/atomic_file.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/io/descriptor.h"

namespace samara::io {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void cannot_write(const fs::path& path, const std::string& reason) {
  throw ArgumentError("cannot write \"" + path.string() + "\": " + reason);
}

/// A name that no other thread or process uses now; its length does not depend on the final name, which may
/// already be as long as the file system allows.
std::string temporary_name() {
  static std::atomic<unsigned> counter{0};
  std::random_device entropy;
  return ".samara-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + "-" +
         std::to_string(entropy()) + ".tmp";
}

void write_all(int descriptor, std::string_view text, const fs::path& path) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) cannot_write(path, std::strerror(errno));
    text.remove_prefix(static_cast<std::size_t>(count));
  }
}

/// Whether it is one of those that /dev/stdout and /dev/fd/3 lead to, where each is named by its number.
bool is_descriptor(const fs::path& path) {
  std::error_code error;
  return fs::equivalent(path.parent_path(), "/proc/self/fd", error);
}

/// The path that symbolic links lead to, also those that lead to no file yet; descriptors are not followed.
fs::path followed(const fs::path& given) {
  constexpr int kMostLinks = 40;  // as the kernel's
  fs::path path = given;
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(path, error)) && !is_descriptor(path); ++links) {
    if (links == kMostLinks) cannot_write(given, "its symbolic links lead round in a circle");
    const fs::path next = fs::read_symlink(path, error);
    if (error) cannot_write(given, error.message());
    path = path.parent_path() / next;  // `next` itself where it is absolute
  }
  return path;
}

mode_t mode_of(const fs::file_status& status) {
  return static_cast<mode_t>(status.permissions()) & 0777;
}

bool is_stream(const fs::file_status& status) {
  return fs::is_character_file(status) || fs::is_fifo(status) || fs::is_socket(status);
}

/// The descriptor that is open at the regular file which the path leads to: any by its own name, stdout and stderr by
/// every name. Others write to such a file, too (`>> log.txt`), so it is not replaced.
std::optional<int> descriptor_at(const fs::path& given) {
  struct stat there = {}, open = {};
  if (::stat(given.c_str(), &there) != 0 || !S_ISREG(there.st_mode)) return std::nullopt;
  const fs::path target = followed(given);
  if (is_descriptor(target)) return std::atoi(target.filename().c_str());
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO}) {
    if (::fstat(descriptor, &open) == 0 && open.st_dev == there.st_dev && open.st_ino == there.st_ino)
      return descriptor;
  }
  return std::nullopt;
}

std::string name_of(int descriptor) {
  if (descriptor == STDOUT_FILENO) return "stdout";
  return descriptor == STDERR_FILENO ? "stderr" : "descriptor " + std::to_string(descriptor);
}

void require_open_for_writing(int descriptor, const fs::path& path) {
  if ((::fcntl(descriptor, F_GETFL) & O_ACCMODE) == O_RDONLY)
    cannot_write(path, name_of(descriptor) + " is open for reading only");
}

}  // namespace

PendingFile::PendingFile(const fs::path& final_path) : given_(final_path), target_(followed(final_path)) {
  std::error_code error;
  const fs::file_status status = fs::status(target_, error);
  if (fs::exists(status)) {
    if (fs::is_directory(status)) cannot_write(given_, "it is a directory");
    if (!fs::is_regular_file(status)) cannot_write(given_, "it is not a regular file");
    if (const auto open = descriptor_at(given_))
      cannot_write(given_, "it is where " + name_of(*open) + " leads; a file of its own was expected");
  } else if (error && error != std::errc::no_such_file_or_directory && error != std::errc::not_a_directory) {
    cannot_write(given_, error.message());  // a name that is too long, above all
  }
  const fs::path directory = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  if (target_.filename().empty()) cannot_write(given_, "the path names no file");
  if (!fs::exists(directory, error))
    cannot_write(given_, "the directory " + directory.string() + " does not exist");
  const fs::path candidate = directory / temporary_name();
  const Descriptor file(::open(candidate.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666));
  if (!file.valid()) cannot_write(given_, std::strerror(errno));
  temporary_ = candidate;
  // Whoever was kept from the old content is kept from the new; but its owner has to write it. Where a file system has
  // no permissions there is nothing to keep.
  if (fs::exists(status)) ::fchmod(file.get(), mode_of(status) | S_IRUSR | S_IWUSR);
}

PendingFile::~PendingFile() {
  discard();
}

PendingFile::PendingFile(PendingFile&& other) noexcept
    : given_(std::move(other.given_)),
      target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})) {}

PendingFile& PendingFile::operator=(PendingFile&& other) noexcept {
  if (this == &other) return *this;
  discard();
  given_ = std::move(other.given_);
  target_ = std::move(other.target_);
  temporary_ = std::exchange(other.temporary_, {});
  return *this;
}

void PendingFile::discard() noexcept {
  if (temporary_.empty()) return;
  std::error_code ignored;
  fs::remove(temporary_, ignored);
  temporary_.clear();
}

void PendingFile::write(std::string_view content) {
  if (temporary_.empty()) cannot_write(given_, "it was committed before");
  const Descriptor file(::open(temporary_.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC));
  if (!file.valid()) cannot_write(given_, std::strerror(errno));
  write_all(file.get(), content, given_);
}

void PendingFile::commit() {
  if (temporary_.empty()) cannot_write(given_, "it was committed before");
  std::error_code error;
  {
    const Descriptor file(::open(temporary_.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.valid() || ::fsync(file.get()) != 0) cannot_write(given_, std::strerror(errno));
    const fs::file_status replaced = fs::status(target_, error);
    if (fs::exists(replaced)) ::fchmod(file.get(), mode_of(replaced));
  }
  fs::rename(temporary_, target_, error);
  if (error) cannot_write(given_, error.message());
  // The new name reaches the disk with the directory; where a file system has no such call, the content is
  // safe all the same.
  const Descriptor directory(::open(temporary_.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.valid()) ::fsync(directory.get());
  temporary_.clear();
}

void require_writable(const fs::path& path) {
  std::error_code error;
  if (is_stream(fs::status(path, error))) {
    if (::access(path.c_str(), W_OK) != 0) cannot_write(path, std::strerror(errno));
    return;
  }
  if (const auto open = descriptor_at(path)) return require_open_for_writing(*open, path);
  const PendingFile probe(path);
}

void require_name_of_format(const fs::path& path, std::string_view ending) {
  constexpr std::array<std::string_view, 23> kOfFormats = {
      ".h5",  ".hdf5", ".csv",  ".tsv", ".txt", ".json", ".toml", ".yaml", ".yml", ".png",  ".svg", ".html",
      ".glb", ".usda", ".gltf", ".fbx", ".obj", ".stl",  ".ply",  ".vtu",  ".pvd", ".xdmf", ".flat"};
  const std::string found = ending_of(path);
  const bool is_hdf5 = ending == ".h5";
  if (found == ending || found == (is_hdf5 ? ".hdf5" : ".txt")) return;
  if (std::ranges::count(kOfFormats, found) == 0) return;
  const std::string format = is_hdf5             ? "HDF5"
                             : ending == ".csv"  ? "CSV"
                             : ending == ".json" ? "JSON"
                             : ending == ".toml" ? "TOML"
                                                 : "text";
  throw ArgumentError("the output is \"" + path.string() + "\", but " + format +
                      " is written; a name that ends in " + std::string(ending) + " was expected");
}

void write_text_atomically(const fs::path& path, std::string_view text) {
  std::error_code error;
  if (is_stream(fs::status(path, error))) {
    const Descriptor stream(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    if (!stream.valid()) cannot_write(path, std::strerror(errno));
    write_all(stream.get(), text, path);
    return;
  }
  if (const auto open = descriptor_at(path)) {
    require_open_for_writing(*open, path);
    const Descriptor file(::fcntl(*open, F_DUPFD_CLOEXEC, 0));
    if (!file.valid()) cannot_write(path, std::strerror(errno));
    write_all(file.get(), text, path);
    return;
  }
  PendingFile pending(path);
  pending.write(text);
  pending.commit();
}

}  // namespace samara::io
