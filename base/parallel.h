#pragma once

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <exception>
#include <functional>
#include <thread>
#else
#include <tbb/parallel_for.h>
#endif

namespace samara {

#ifdef __SANITIZE_THREAD__

/// The loop below on threads that the sanitizer sees through: it does not look into TBB's library, and takes what that
/// orders for races.
template <class Index, class Body>
void parallel_for(Index count, const Body& body) {
  std::atomic<Index> next = 0;
  std::exception_ptr thrown[2];
  const auto work = [&](std::exception_ptr& failure) {
    try {
      for (Index i = next++; i < count; i = next++) body(i);
    } catch (...) {
      failure = std::current_exception();
      next = count;
    }
  };
  if (count > 1) {
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

/// body(i) for 0 <= i < count, in any order, on the threads of the arena in which it is called.
template <class Index, class Body>
void parallel_for(Index count, const Body& body) {
  tbb::parallel_for(Index{0}, count, body);
}

#endif

}  // namespace samara
