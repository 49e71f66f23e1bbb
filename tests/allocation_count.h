#pragma once

#include <atomic>
#include <cstddef>

/// How many calls of the allocator a piece of work takes, and how much memory it holds at once, where one source of the
/// program includes allocation_counter.h.

namespace allocation_counter {

inline std::atomic<bool> counting{false};
inline std::atomic<long> calls{0};

inline void count() noexcept {
  if (counting.load(std::memory_order_relaxed)) calls.fetch_add(1, std::memory_order_relaxed);
}

inline std::atomic<long long> held{0}, most_held{0};  ///< bytes

inline void gain(std::size_t bytes) noexcept {
  if (!counting.load(std::memory_order_relaxed)) return;
  const long long now = held.fetch_add(static_cast<long long>(bytes)) + static_cast<long long>(bytes);
  long long most = most_held.load();
  while (most < now && !most_held.compare_exchange_weak(most, now)) {
  }
}
inline void lose(std::size_t bytes) noexcept {
  if (counting.load(std::memory_order_relaxed)) held.fetch_sub(static_cast<long long>(bytes));
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

/// Most bytes that `work` held at once, beside what was there before.
template <class Work>
long long most_bytes_during(const Work& work) {
  held = most_held = 0;
  counting = true;
  work();
  counting = false;
  return most_held;
}

}  // namespace allocation_counter
