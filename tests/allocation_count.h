#pragma once

#include <atomic>

/// How many calls of the allocator a piece of work takes, where one source of the program includes allocation_counter.h.

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
