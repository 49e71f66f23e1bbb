#include "report.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <limits>
#include <vector>

#include <nlohmann/json.hpp>

#include "samara/base/errors.h"

namespace samara::benchmarks {

namespace {
using Clock = std::chrono::steady_clock;

double seconds(Clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

double time_calls(const std::function<void()>& call, long count) {
  const Clock::time_point begin = Clock::now();
  for (long i = 0; i < count; ++i) call();
  return seconds(Clock::now() - begin) / static_cast<double>(count);
}
}  // namespace

void print(const Measurement& m) {
  nlohmann::ordered_json line = {
      {"bench", m.bench}, {"case", m.test_case}, {"metric", m.metric}, {"value", m.value}, {"unit", m.unit}};
  if (!m.baseline.empty()) line["baseline"] = m.baseline;
  if (m.ratio) line["ratio"] = *m.ratio;
  std::cout << line.dump() << std::endl;
}

double time_of(const std::function<void()>& call, int repeats, double least_seconds) {
  const double once = time_calls(call, 1);
  const long count = std::max(1L, static_cast<long>(least_seconds / std::max(once, 1e-9)));
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) times.push_back(time_calls(call, count));
  std::nth_element(times.begin(), times.begin() + repeats / 2, times.end());
  return times[static_cast<std::size_t>(repeats / 2)];
}

Pair time_both(const std::function<void()>& ours, const std::function<void()>& theirs, int rounds) {
  constexpr double kSlice = 2e-3;
  const auto count_of = [&](const std::function<void()>& call) {
    call();
    return std::max(1L, static_cast<long>(kSlice / std::max(time_calls(call, 3), 1e-9)));
  };
  const long a = count_of(ours), b = count_of(theirs);
  Pair best{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (int i = 0; i < rounds; ++i) {
    best.ours = std::min(best.ours, time_calls(ours, a));
    best.theirs = std::min(best.theirs, time_calls(theirs, b));
  }
  return best;
}

Options options(int argc, char** argv) {
  Options result;
  for (int i = 1; i < argc; ++i) {
    const std::string text = argv[i];
    if (text == "--quick") {
      result.quick = true;
    } else if (text == "--pictures" && i + 1 < argc) {
      result.pictures = argv[++i];
    } else if (text.starts_with("-") || !result.only_case.empty()) {
      throw ArgumentError("unknown argument \"" + text + "\", expected [--quick] [--pictures FOLDER] [CASE]");
    } else {
      result.only_case = text;
    }
  }
  return result;
}

}  // namespace samara::benchmarks
