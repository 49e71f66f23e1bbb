#include "samara/io/memory_file.h"

#include <cerrno>
#include <string>
#include <system_error>

#include <sys/mman.h>
#include <unistd.h>

#include "samara/base/errors.h"

namespace samara::io {

namespace {

NoResultError no_room(std::size_t bytes) {
  return NoResultError("a file of " + std::to_string(bytes) +
                       " bytes cannot be kept in memory: " + std::generic_category().message(errno));
}

}  // namespace

MemoryFile::MemoryFile(std::string_view bytes) : descriptor_(::memfd_create("samara", MFD_CLOEXEC)) {
  if (descriptor_ < 0) throw no_room(bytes.size());
  for (std::string_view rest = bytes; !rest.empty();) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const NoResultError error = no_room(bytes.size());
      ::close(descriptor_);
      throw error;
    }
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  path_ = "/proc/self/fd/" + std::to_string(descriptor_);
}

MemoryFile::~MemoryFile() {
  ::close(descriptor_);
}

}  // namespace samara::io
