#pragma once

#include <atomic>
#include <cerrno>
#include <cstddef>

/// Counts calls of the allocator: malloc and its relatives are defined here, for the whole program with its
/// shared libraries, on top of those of the GNU C library. To be included in one source file of a program.

namespace allocation_counter {

inline std::atomic<bool> counting{false};
inline std::atomic<long> calls{0};

inline void count() noexcept {
  if (counting.load(std::memory_order_relaxed)) calls.fetch_add(1, std::memory_order_relaxed);
}

/// Calls of the allocator during `work`.
template <class Work>
long during(const Work& work) {
  calls = 0;
  counting = true;
  work();
  counting = false;
  return calls;
}

}  // namespace allocation_counter

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t number, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* memory);

void* malloc(std::size_t size) noexcept {
  allocation_counter::count();
  return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) noexcept {
  allocation_counter::count();
  return __libc_calloc(number, size);
}
void* realloc(void* memory, std::size_t size) noexcept {
  allocation_counter::count();
  return __libc_realloc(memory, size);
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  allocation_counter::count();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  allocation_counter::count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  allocation_counter::count();
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
void free(void* memory) noexcept {
  if (memory != nullptr) allocation_counter::count();
  __libc_free(memory);
}
}
