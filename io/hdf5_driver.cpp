#include "samara/io/hdf5_driver.h"

#include <cerrno>
#include <limits>
#include <memory>

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

herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, size_t size, void* buffer) {
  const GuardedFile& from = own(file);
  if (address > from.size || size > from.size - address) return -1;
  auto* to = static_cast<char*>(buffer);
  while (size > 0) {
    const ssize_t got = ::pread(from.descriptor, to, size, static_cast<off_t>(address));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return -1;
    to += got;
    address += static_cast<haddr_t>(got);
    size -= static_cast<size_t>(got);
  }
  return 0;
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
