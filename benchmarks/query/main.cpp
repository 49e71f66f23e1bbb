/// Answers of codebooks against the best that one writes without them, in the same process, writing the same
/// numbers: points, trajectories, batches, residuals with derivatives; size; opening; damaged files.
#include <algorithm>
#include <chrono>
#include <exception>
#include <iostream>
#include <limits>

#include "cases.h"

namespace samara::benchmarks {

Pair time_both(const std::function<void()>& ours, const std::function<void()>& theirs, int rounds) {
  using Clock = std::chrono::steady_clock;
  const auto seconds = [](const std::function<void()>& call, long count) {
    const Clock::time_point begin = Clock::now();
    for (long i = 0; i < count; ++i) call();
    return std::chrono::duration<double>(Clock::now() - begin).count() / static_cast<double>(count);
  };
  constexpr double kSlice = 2e-3;
  const auto count_of = [&](const std::function<void()>& call) {
    call();
    return std::max(1L, static_cast<long>(kSlice / std::max(seconds(call, 3), 1e-9)));
  };
  const long a = count_of(ours), b = count_of(theirs);
  Pair best{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (int i = 0; i < rounds; ++i) {
    best.ours = std::min(best.ours, seconds(ours, a));
    best.theirs = std::min(best.theirs, seconds(theirs, b));
  }
  return best;
}

}  // namespace samara::benchmarks

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    run_plates(chosen);
    run_body(chosen);
    run_trains(chosen);
    run_files(chosen);
  } catch (const std::exception& error) {
    std::cerr << "query: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
