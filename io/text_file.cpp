#include "samara/io/text_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>

#include "samara/base/errors.h"
#include "samara/base/number_text.h"
#include "samara/base/text.h"
#include "samara/io/descriptor.h"

namespace samara::io {

namespace {

/// "256 MB", "10 bytes"
std::string bytes_text(std::size_t bytes) {
  constexpr std::size_t kMega = std::size_t{1} << 20;
  return bytes % kMega == 0 ? std::to_string(bytes / kMega) + " MB" : std::to_string(bytes) + " bytes";
}

/// Waits until there is something to read, or the end.
void await_data(const std::string& name, int descriptor, double silence) {
  constexpr double kLongest = 1e6;  // s; poll counts milliseconds in an int
  pollfd event = {descriptor, POLLIN, 0};
  const auto milliseconds = static_cast<int>(std::ceil(1e3 * std::min(silence, kLongest)));
  const int ready = ::poll(&event, 1, milliseconds);
  if (ready == 0) {
    throw InputError(name, "gave nothing to read for " + number_text(silence) + " s, expected a text");
  }
  if (ready < 0 && errno != EINTR) throw InputError(name, std::strerror(errno));
}

}  // namespace

std::string binary_kind(std::string_view beginning) {
  using namespace std::string_view_literals;
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kKinds = {{
      {"\x89HDF\r\n\x1a\n"sv, "an HDF5 file, such as a codebook (samara info shows it)"},
      {"\x89PNG\r\n\x1a\n"sv, "a PNG picture"},
      {"\xff\xd8\xff"sv, "a JPEG picture"},
      {"PK\x03\x04"sv, "an archive (zip, npz)"},
      {"\x93NUMPY"sv, "an array of NumPy"},
      {"\x1f\x8b"sv, "a file compressed by gzip"},
      {"glTF"sv, "a glTF scene"},
      {"%PDF-"sv, "a PDF"},
  }};
  for (const auto& [start, kind] : kKinds) {
    if (beginning.starts_with(start)) return std::string(kind);
  }
  return {};
}

std::string read_text_file(const std::filesystem::path& path, const TextLimits& limits) {
  const std::string name = path.string();
  // Without waiting: opening a pipe that has no writer would never return.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!file.valid()) {
    if (errno == ENOENT) throw InputError(name, "the file does not exist");
    throw InputError(name, std::string("cannot be opened: ") + std::strerror(errno));
  }
  struct stat status = {};
  if (::fstat(file.get(), &status) != 0)
    throw InputError(name, std::string("cannot be read: ") + std::strerror(errno));
  if (S_ISDIR(status.st_mode)) throw InputError(name, "is a directory, expected a file");
  std::string text;
  // Of a large file, so that it is not copied while it grows. What the system says of its size is a guess.
  if (S_ISREG(status.st_mode) && status.st_size > 0)
    text.reserve(std::min(static_cast<std::size_t>(status.st_size), limits.bytes) + 1);
  std::array<char, 65536> block;
  while (true) {
    if (!S_ISREG(status.st_mode)) await_data(name, file.get(), limits.silence);
    const ssize_t count = ::read(file.get(), block.data(), block.size());
    if (count == 0) return text;
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) {  // some files of the kernel say that they are regular, and wait
      await_data(name, file.get(), limits.silence);
      continue;
    }
    if (count < 0) throw InputError(name, std::string("cannot be read to its end: ") + std::strerror(errno));
    const bool is_asked = text.empty() && !limits.expected.empty();
    text.append(block.data(), static_cast<std::size_t>(count));
    if (const std::string kind = is_asked ? binary_kind(text) : ""; !kind.empty())
      throw InputError(name, "is " + kind + ", expected " + limits.expected);
    if (text.size() > limits.bytes)
      throw InputError(name, "holds more than " + bytes_text(limits.bytes) + ", expected a shorter text");
  }
}

}  // namespace samara::io
