#include "samara/codebooks/child_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <ctime>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace samara::codebooks {

namespace {

using Clock = std::chrono::steady_clock;

class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  int get() const { return number_; }
  bool is_open() const { return number_ >= 0; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_ = -1;
};

struct Pipe {
  Pipe() : Pipe(opened()) {}
  Descriptor reading, writing;

 private:
  explicit Pipe(const std::array<int, 2>& ends) : reading(ends[0]), writing(ends[1]) {}
  static std::array<int, 2> opened() {
    std::array<int, 2> ends = {-1, -1};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) return {-1, -1};
    return ends;
  }
};

/// A program that ends early makes writing to it a signal, which would end us: held back for this thread.
class NoPipeSignal {
 public:
  NoPipeSignal() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  NoPipeSignal(const NoPipeSignal&) = delete;
  NoPipeSignal& operator=(const NoPipeSignal&) = delete;
  ~NoPipeSignal() {
    const timespec now = {0, 0};
    if (sigismember(&before_, SIGPIPE) == 0) {
      while (sigtimedwait(&pipe_, nullptr, &now) > 0) continue;
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  const sigset_t& before() const { return before_; }

 private:
  sigset_t pipe_, before_;
};

/// @returns 0 or errno
int spawn(const std::vector<std::string>& run, const sigset_t& mask, const Pipe& in, const Pipe& out,
          const Pipe& err, pid_t& child) {
  std::vector<char*> arguments;
  for (const std::string& word : run) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, in.reading.get(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, out.writing.get(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, err.writing.get(), STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setsigmask(&attributes, &mask);
  const int problem = posix_spawnp(&child, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return problem;
}

/// The running program: writes and reads what is ready, until it is done or a limit is reached.
class Conversation {
 public:
  Conversation(Pipe& in, Pipe& out, Pipe& err, const std::string& input, const ChildLimits& limits)
      : in_(in.writing),
        out_(out.reading),
        err_(err.reading),
        input_(input),
        limits_(limits),
        deadline_(Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                     std::chrono::duration<double>(limits.seconds))) {
    fcntl(in_.get(), F_SETFL, O_NONBLOCK);
    if (input_.empty()) in_.close();
  }

  /// @returns exited once both streams have ended, else the limit that was reached
  ChildResult::End run(ChildResult& result) {
    while (out_.is_open() || err_.is_open()) {
      const int left = milliseconds_left();
      if (left <= 0) return ChildResult::End::timed_out;
      std::array<pollfd, 3> events = {pollfd{out_.get(), POLLIN, 0}, pollfd{err_.get(), POLLIN, 0},
                                      pollfd{in_.get(), POLLOUT, 0}};
      if (poll(events.data(), events.size(), left) < 0 && errno != EINTR) return ChildResult::End::timed_out;
      if (events[0].revents != 0) read_some(out_, result.output);
      if (events[1].revents != 0) read_some(err_, result.errors);
      if (events[2].revents != 0) write_some();
      if (result.output.size() > limits_.output_bytes) return ChildResult::End::too_much_output;
      if (result.errors.size() > 2 * kErrorsKept) result.errors.erase(0, result.errors.size() - kErrorsKept);
    }
    return ChildResult::End::exited;
  }

  /// Waits until the program has ended, without taking it from the list of processes: its number stays its
  /// own.
  bool ends_in_time(pid_t child) const {
    while (true) {
      siginfo_t info = {};
      if (waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) != 0) return true;
      if (info.si_pid == child) return true;
      if (milliseconds_left() <= 0) return false;
      const timespec pause = {0, 1'000'000};
      nanosleep(&pause, nullptr);
    }
  }

 private:
  static constexpr std::size_t kErrorsKept = 4096;

  int milliseconds_left() const {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now()).count();
    constexpr long kLongest = 1000;
    return static_cast<int>(std::clamp<long>(left, 0, kLongest));
  }

  static void read_some(Descriptor& from, std::string& text) {
    std::array<char, 65536> buffer{};
    const ssize_t count = ::read(from.get(), buffer.data(), buffer.size());
    if (count > 0) text.append(buffer.data(), static_cast<std::size_t>(count));
    if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) from.close();
  }

  void write_some() {
    const ssize_t count = ::write(in_.get(), input_.data() + written_, input_.size() - written_);
    if (count > 0) written_ += static_cast<std::size_t>(count);
    // A program that does not read all of its input may be right nevertheless.
    if (written_ == input_.size() || (count < 0 && errno != EINTR && errno != EAGAIN)) in_.close();
  }

  Descriptor& in_;
  Descriptor& out_;
  Descriptor& err_;
  const std::string& input_;
  const ChildLimits& limits_;
  Clock::time_point deadline_;
  std::size_t written_ = 0;
};

}  // namespace

ChildResult run_child(const std::vector<std::string>& run, const std::string& input,
                      const ChildLimits& limits) {
  ChildResult result;
  Pipe in, out, err;
  if (!in.reading.is_open() || !out.reading.is_open() || !err.reading.is_open()) {
    result.code = errno;
    return result;
  }
  const NoPipeSignal guard;
  pid_t child = 0;
  result.code = spawn(run, guard.before(), in, out, err, child);
  if (result.code != 0) return result;
  in.reading.close();
  out.writing.close();
  err.writing.close();
  Conversation conversation(in, out, err, input, limits);
  result.end = conversation.run(result);
  if (result.end == ChildResult::End::exited && !conversation.ends_in_time(child))
    result.end = ChildResult::End::timed_out;
  kill(-child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (result.end != ChildResult::End::exited) return result;
  if (WIFSIGNALED(status)) {
    result.end = ChildResult::End::killed;
    result.code = WTERMSIG(status);
  } else {
    result.code = WEXITSTATUS(status);
  }
  return result;
}

}  // namespace samara::codebooks
