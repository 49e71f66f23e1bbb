#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

/// What every benchmark prints, and how it takes times.
namespace samara::benchmarks {

struct Measurement {
  std::string bench;
  std::string test_case;
  std::string metric;
  double value = 0.0;
  std::string unit = "1";
  std::string baseline = {};         ///< empty: none
  std::optional<double> ratio = {};  ///< the baseline's time over ours
};

/// One JSON object on one line of stdout.
void print(const Measurement& measurement);

/// Median time of one call in seconds, over `repeats` timings of as many calls as fill about `least_seconds`
/// each.
double time_of(const std::function<void()>& call, int repeats = 9, double least_seconds = 0.01);

/// Shortest times of two calls, taken in turns so that what else the machine does meets both.
struct Pair {
  double ours = 0.0;
  double theirs = 0.0;
  double ratio() const { return theirs / ours; }
};
Pair time_both(const std::function<void()>& ours, const std::function<void()>& theirs, int rounds = 25);

struct Options {
  bool quick = false;              ///< fewer repeats, the same cases
  std::string only_case;           ///< empty: all
  std::filesystem::path pictures;  ///< where cases put pictures; empty: they draw none
  bool wants(const std::string& test_case) const { return only_case.empty() || only_case == test_case; }
};

/// Reads `[--quick] [--pictures FOLDER] [CASE]`. @throws ArgumentError for anything else.
Options options(int argc, char** argv);

}  // namespace samara::benchmarks
