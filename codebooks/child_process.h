#pragma once

#include <string>
#include <vector>

namespace samara::codebooks {

/// How a program ended, and what it printed.
struct ChildResult {
  enum class End { exited, killed, timed_out, too_much_output, not_started };
  End end = End::not_started;
  int code = 0;  ///< exit code, number of the signal, or errno of what prevented the start
  std::string output;
  std::string errors;  ///< the last part of its standard error
};

struct ChildLimits {
  double seconds = 60.0;
  std::size_t output_bytes = 1 << 20;
};

/// Starts a program in a process group of its own, writes `input` to its standard input and reads what it
/// prints until it ends. Whatever is left of the group then is killed.
ChildResult run_child(const std::vector<std::string>& run, const std::string& input,
                      const ChildLimits& limits);

}  // namespace samara::codebooks
