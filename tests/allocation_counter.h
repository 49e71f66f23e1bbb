#pragma once

#include <cerrno>
#include <cstddef>

#include <malloc.h>

#include "allocation_count.h"

/// Counts calls of the allocator, and what it gives: malloc and its relatives are defined here, for the
/// whole program with its shared libraries, on top of those of the GNU C library. To be included in one
/// source file of a program. Sanitizers define malloc themselves, and start after the first calls of it:
/// with one nothing is counted, and all counts are 0.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace allocation_counter {
inline void* given(void* memory) noexcept {
  count();
  if (memory != nullptr) gain(malloc_usable_size(memory));
  return memory;
}
}  // namespace allocation_counter

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t number, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* memory);

void* malloc(std::size_t size) noexcept {
  return allocation_counter::given(__libc_malloc(size));
}
void* calloc(std::size_t number, std::size_t size) noexcept {
  return allocation_counter::given(__libc_calloc(number, size));
}
void* realloc(void* memory, std::size_t size) noexcept {
  if (memory != nullptr) allocation_counter::lose(malloc_usable_size(memory));
  return allocation_counter::given(__libc_realloc(memory, size));
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  return allocation_counter::given(__libc_memalign(alignment, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return allocation_counter::given(__libc_memalign(alignment, size));
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  *memory = allocation_counter::given(__libc_memalign(alignment, size));
  return *memory == nullptr ? ENOMEM : 0;
}
void free(void* memory) noexcept {
  if (memory != nullptr) allocation_counter::count();
  if (memory != nullptr) allocation_counter::lose(malloc_usable_size(memory));
  __libc_free(memory);
}
}

#endif
