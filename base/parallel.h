#pragma once

#include <cstddef>

namespace samara {

/// What parallel_for() below runs on, compiled once: to read TBB's headers takes most of a second, in every source that
/// loops.
/// @param step calls the body that is handed over, for one index
void parallel_steps(std::ptrdiff_t count, const void* body, void (*step)(const void* body, std::ptrdiff_t i));

/// body(i) for 0 <= i < count, in any order, on the threads of the TBB arena in which it is called. What a body throws
/// ends the loop, and passes to the caller.
template <class Index, class Body>
void parallel_for(Index count, const Body& body) {
  parallel_steps(static_cast<std::ptrdiff_t>(count), &body, [](const void* loop_body, std::ptrdiff_t i) {
    (*static_cast<const Body*>(loop_body))(static_cast<Index>(i));
  });
}

}  // namespace samara
