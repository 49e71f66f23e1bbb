#include "samara/codebooks/source/journal.h"

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "samara/base/errors.h"
#include "samara/io/atomic_file.h"
#include "samara/io/checksum.h"
#include "samara/io/descriptor.h"

namespace samara::codebooks {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBegin = "samara journal 1\n";

/// In front of every record.
struct RecordHead {
  std::uint64_t length = 0;
  std::uint64_t of_record = 0;  ///< checksum
  std::uint64_t of_head = 0;    ///< of what stands before it
};

std::uint64_t checksum(const RecordHead& head) {
  return io::fnv1a(std::as_bytes(std::span(&head, 1)).first(offsetof(RecordHead, of_head)));
}

RecordHead head_of(std::string_view record) {
  RecordHead head{record.size(), io::fnv1a(record), 0};
  head.of_head = checksum(head);
  return head;
}

std::string framed(std::string_view record) {
  const RecordHead head = head_of(record);
  std::string bytes(reinterpret_cast<const char*>(&head), sizeof head);
  return bytes.append(record);
}

/// The whole record at the front; empty if there is none.
std::string_view first_record(std::string_view bytes) {
  RecordHead head;
  if (bytes.size() < sizeof head) return {};
  std::memcpy(&head, bytes.data(), sizeof head);
  bytes.remove_prefix(sizeof head);
  if (head.of_head != checksum(head) || head.length > bytes.size()) return {};
  const std::string_view record = bytes.substr(0, head.length);
  return io::fnv1a(record) == head.of_record ? record : std::string_view();
}

[[noreturn]] void cannot_add(const fs::path& path, int reason) {
  throw ArgumentError("cannot write \"" + path.string() + "\": " + std::strerror(reason));
}

/// @returns 0, or why not all was written
int written(int file, std::string_view bytes, std::uint64_t at) {
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    bytes.remove_prefix(static_cast<std::size_t>(count));
    at += static_cast<std::uint64_t>(count);
  }
  return ::fdatasync(file) == 0 ? 0 : errno;
}

}  // namespace

bool is_journal(const fs::path& path) {
  std::string begin(kBegin.size(), '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return begin == kBegin;
}

Journal::Journal(const fs::path& path, const std::vector<std::string>& records) : path_(path) {
  std::string bytes(kBegin);
  for (const std::string& record : records) bytes += framed(record);
  io::write_text_atomically(path, bytes);
  size_ = found_size_ = bytes.size();
  remember_file();
}

Journal::Journal(const fs::path& path, std::vector<std::string>* records) : path_(path) {
  std::ifstream stream(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  if (!stream.good() && !stream.eof()) throw InputError(path.string(), "cannot be read");
  std::string_view rest = bytes;
  if (!rest.starts_with(kBegin)) throw InputError(path.string(), "is no journal of Samara");
  rest.remove_prefix(kBegin.size());
  records->clear();
  for (std::string_view record = first_record(rest); !record.empty(); record = first_record(rest)) {
    records->emplace_back(record);
    rest.remove_prefix(sizeof(RecordHead) + record.size());
  }
  size_ = bytes.size() - rest.size();
  found_size_ = bytes.size();
  remember_file();
}

void Journal::append(std::string_view record) {
  const std::string bytes = framed(record);
  const io::Descriptor file(::open(path_.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file.valid()) cannot_add(path_, errno);
  int reason = found_size_ > size_ && ::ftruncate(file.get(), static_cast<off_t>(size_)) != 0 ? errno : 0;
  if (reason == 0) reason = written(file.get(), bytes, size_);
  if (reason != 0) {
    // What was written of it is no record, and need not take the room.
    const bool is_cut = ::ftruncate(file.get(), static_cast<off_t>(size_)) == 0;
    found_size_ = is_cut ? size_ : size_ + bytes.size();
    cannot_add(path_, reason);
  }
  size_ += bytes.size();
  found_size_ = size_;
}

void Journal::remember_file() {
  struct stat status = {};
  if (::stat(path_.c_str(), &status) == 0) inode_ = status.st_ino;
}

bool Journal::is_as_left() const {
  struct stat status = {};
  return ::stat(path_.c_str(), &status) == 0 && status.st_ino == inode_ &&
         static_cast<std::uint64_t>(status.st_size) == found_size_;
}

}  // namespace samara::codebooks
