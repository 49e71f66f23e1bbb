#include "samara/base/parallel.h"

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <exception>
#include <functional>
#include <thread>

#include <tbb/task_arena.h>
#else
#include <tbb/parallel_for.h>
#endif

namespace samara {

#ifdef __SANITIZE_THREAD__

// On threads that the sanitizer sees through: it does not look into TBB's library, and takes what that orders for
// races. Two threads find what more would, where the arena allows more than one.
void parallel_steps(std::ptrdiff_t count, const void* body,
                    void (*step)(const void* body, std::ptrdiff_t i)) {
  std::atomic<std::ptrdiff_t> next = 0;
  std::exception_ptr thrown[2];
  const auto work = [&](std::exception_ptr& failure) {
    try {
      for (std::ptrdiff_t i = next++; i < count; i = next++) step(body, i);
    } catch (...) {
      failure = std::current_exception();
      next = count;
    }
  };
  if (count > 1 && tbb::this_task_arena::max_concurrency() > 1) {
    std::thread other(work, std::ref(thrown[1]));
    work(thrown[0]);
    other.join();
  } else {
    work(thrown[0]);
  }
  for (const std::exception_ptr& failure : thrown) {
    if (failure) std::rethrow_exception(failure);
  }
}

#else

void parallel_steps(std::ptrdiff_t count, const void* body,
                    void (*step)(const void* body, std::ptrdiff_t i)) {
  tbb::parallel_for(std::ptrdiff_t{0}, count, [&](std::ptrdiff_t i) { step(body, i); });
}

#endif

}  // namespace samara
