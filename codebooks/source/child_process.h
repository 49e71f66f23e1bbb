#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace samara::codebooks {

/// How a conversation with a program ended, and what it printed.
struct ChildResult {
  enum class End {
    answered,  ///< all lines are there, and the program goes on
    exited,
    killed,         ///< by a signal that was not ours
    closed,         ///< it closed its output and went on
    unasked,        ///< it printed before anything was asked
    not_listening,  ///< it closed its input
    timed_out,
    too_much_output,
    not_started,
  };
  End end = End::not_started;
  int code = 0;  ///< exit code, number of the signal, or errno of what prevented the start
  std::string output;
  std::string errors;  ///< the last part of its standard error
};

struct ChildLimits {
  double seconds = 60.0;  ///< of one conversation
  std::size_t output_bytes = 1 << 20;
};

struct ChildStreams;

/// A program in a process group of its own, which is killed with it: when a conversation ends otherwise than
/// `answered`, and by the destructor. May be used by one thread at a time.
class ChildProcess {
 public:
  /// Starts it. That it could not be started is told by the first conversation.
  explicit ChildProcess(const std::vector<std::string>& run);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  /// Closes its input and gives it two seconds to end by itself.
  ~ChildProcess();

  /// Writes `input`, closes it, and reads what the program prints until it ends. It cannot be asked again.
  ChildResult finish(const std::string& input, const ChildLimits& limits);

  /// Writes `input` and reads until there are so many lines that are not empty; what came with the last of
  /// them is part of the output, too. Both at once, so that no program waits for us while we wait for it.
  ChildResult ask(const std::string& input, std::size_t lines, const ChildLimits& limits);

  /// Kills it with all that it started.
  void kill();

 private:
  void end(ChildResult& result, bool in_time);

  std::unique_ptr<ChildStreams> streams_;
  int process_ = 0;  ///< 0: there is none
  int problem_ = 0;  ///< errno of what prevented the start
};

}  // namespace samara::codebooks
