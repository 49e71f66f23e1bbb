#include "samara/io/hdf5_driver.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace samara::io::hdf5 {

namespace {

constexpr haddr_t kLargestAddress = static_cast<haddr_t>(std::numeric_limits<off_t>::max());

/// The library's part comes first, as it wants it.
struct GuardedFile {
  H5FD_t common = {};
  int descriptor = -1;
  dev_t device = 0;
  ino_t inode = 0;
  haddr_t size = 0;
  haddr_t end = 0;  ///< of what the library thinks is allocated
};

GuardedFile& own(H5FD_t* file) {
  return *reinterpret_cast<GuardedFile*>(file);
}
const GuardedFile& own(const H5FD_t* file) {
  return *reinterpret_cast<const GuardedFile*>(file);
}

H5FD_t* open_file(const char* name, unsigned flags, hid_t, haddr_t) {
  if ((flags & H5F_ACC_RDWR) != 0) return nullptr;
  auto file = std::make_unique<GuardedFile>();
  file->descriptor = ::open(name, O_RDONLY | O_CLOEXEC);
  struct stat status = {};
  if (file->descriptor < 0) return nullptr;
  if (::fstat(file->descriptor, &status) != 0) {
    ::close(file->descriptor);
    return nullptr;
  }
  file->device = status.st_dev;
  file->inode = status.st_ino;
  file->size = static_cast<haddr_t>(status.st_size);
  return &file.release()->common;
}

herr_t close_file(H5FD_t* file) {
  const std::unique_ptr<GuardedFile> owner(&own(file));
  return ::close(owner->descriptor);
}

int compare(const H5FD_t* a, const H5FD_t* b) {
  const GuardedFile& left = own(a);
  const GuardedFile& right = own(b);
  if (left.device != right.device) return left.device < right.device ? -1 : 1;
  if (left.inode != right.inode) return left.inode < right.inode ? -1 : 1;
  return 0;
}

herr_t features(const H5FD_t*, unsigned long* flags) {
  *flags = 0;
  return 0;
}

haddr_t allocated_end(const H5FD_t* file, H5FD_mem_t) {
  return own(file).end;
}

herr_t set_allocated_end(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  own(file).end = end;
  return 0;
}

haddr_t file_end(const H5FD_t* file, H5FD_mem_t) {
  return own(file).size;
}

bool read_at(const GuardedFile& from, haddr_t address, size_t size, void* buffer) {
  if (address > from.size || size > from.size - address) return false;
  auto* to = static_cast<char*>(buffer);
  while (size > 0) {
    const ssize_t got = ::pread(from.descriptor, to, size, static_cast<off_t>(address));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    address += static_cast<haddr_t>(got);
    size -= static_cast<size_t>(got);
  }
  return true;
}

using Bytes = std::vector<unsigned char>;

/// A little-endian number; bytes beyond the end count as 0.
std::uint64_t number_at(std::span<const unsigned char> bytes, std::size_t at, std::size_t width) {
  std::uint64_t number = 0;
  for (std::size_t k = width; k-- > 0;) number = number << 8 | (at + k < bytes.size() ? bytes[at + k] : 0);
  return number;
}

/// Whether a message of data layout has chunks of the size 0, or of no dimension. HDF5 1.10 divides by it.
bool has_empty_chunks(std::span<const unsigned char> layout) {
  constexpr std::uint64_t kChunked = 2, kKept = 0xffffffff;  // the library keeps 32 bits of a size
  const std::uint64_t version = number_at(layout, 0, 1);
  if (version < 3) return true;  // of files older than those that we read
  if (number_at(layout, 1, 1) != kChunked) return false;
  // Version 3: number of sizes, address, sizes. Version 4: flags, number of sizes, bytes of each, sizes.
  const std::uint64_t count = number_at(layout, version == 3 ? 2 : 3, 1);
  const std::uint64_t width = version == 3 ? 4 : number_at(layout, 4, 1);
  std::size_t at = version == 3 ? 11 : 5;
  if (count < 2) return true;  // a dimension, and the element
  for (std::uint64_t k = 0; k < count; ++k, at += width)
    if ((number_at(layout, at, width) & kKept) == 0) return true;
  return false;
}

/// Whether an object header, of version 2, says nothing that makes the library crash.
bool is_harmless_header(const GuardedFile& from, haddr_t address) {
  constexpr std::size_t kLongestPrefix = 34, kMostBlocks = 1000, kLayout = 8, kContinuation = 16;
  Bytes prefix(std::min<haddr_t>(kLongestPrefix, from.size - address));
  if (!read_at(from, address, prefix.size(), prefix.data())) return false;
  const std::uint64_t flags = number_at(prefix, 5, 1);
  const std::size_t begin = std::size_t{6} + ((flags & 0x20) != 0 ? 16 : 0) + ((flags & 0x10) != 0 ? 4 : 0);
  const std::size_t width = std::size_t{1} << (flags & 3), head = (flags & 4) != 0 ? 6 : 4;
  struct Block {
    haddr_t address;
    std::uint64_t size;
  };
  std::vector<Block> blocks = {{address + begin + width, number_at(prefix, begin, width)}};
  for (std::size_t b = 0; b < blocks.size() && b < kMostBlocks; ++b) {
    const Block block = blocks[b];
    if (block.address > from.size || block.size > from.size - block.address) return false;
    Bytes bytes(block.size);
    if (!read_at(from, block.address, bytes.size(), bytes.data())) return false;
    for (std::size_t at = 0; at + head <= bytes.size();) {
      const std::uint64_t type = number_at(bytes, at, 1), size = number_at(bytes, at + 1, 2);
      at += head;
      const auto message = std::span(bytes).subspan(at, std::min<std::size_t>(size, bytes.size() - at));
      if (type == kLayout && has_empty_chunks(message)) return false;
      // Between a signature and a checksum.
      if (type == kContinuation && number_at(message, 8, 8) > 8)
        blocks.push_back({number_at(message, 0, 8) + 4, number_at(message, 8, 8) - 8});
      at += size;
    }
  }
  return true;
}

herr_t read_bytes(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t address, size_t size, void* buffer) {
  constexpr std::string_view kHeader = "OHDR";
  if (!read_at(own(file), address, size, buffer)) return -1;
  const std::string_view bytes(static_cast<const char*>(buffer), size);
  const bool is_header = type == H5FD_MEM_OHDR && bytes.starts_with(kHeader);
  return is_header && !is_harmless_header(own(file), address) ? -1 : 0;
}

herr_t refuse_write(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, size_t, const void*) {
  return -1;
}

H5FD_class_t make_class() {
  H5FD_class_t driver = {};
#ifdef H5FD_CLASS_VERSION
  driver.version = H5FD_CLASS_VERSION;  // since HDF5 1.14, which refuses others
#endif
  driver.name = "samara_guarded";
  driver.maxaddr = kLargestAddress;
  driver.fc_degree = H5F_CLOSE_STRONG;
  driver.open = open_file;
  driver.close = close_file;
  driver.cmp = compare;
  driver.query = features;
  driver.get_eoa = allocated_end;
  driver.set_eoa = set_allocated_end;
  driver.get_eof = file_end;
  driver.read = read_bytes;
  driver.write = refuse_write;
  return driver;
}

}  // namespace

bool use_guarded_driver(hid_t access) {
  static const H5FD_class_t driver = make_class();
  static const hid_t id = H5FDregister(&driver);
  return id >= 0 && H5Pset_driver(access, id, nullptr) >= 0;
}

}  // namespace samara::io::hdf5
