#include "samara/codebooks/source/child_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <ctime>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace samara::codebooks {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kMoment = 1.0;  // s, from the end of a program's streams to its own

class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
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

}  // namespace

struct ChildStreams {
  Descriptor in, out, err;
};

namespace {

/// Counts the lines that are not empty, as they come.
class LineCount {
 public:
  /// @param text longer than at the last call, otherwise the same
  std::size_t in(const std::string& text) {
    for (; seen_ < text.size(); ++seen_) {
      if (text[seen_] == '\n') {
        count_ += has_text_ ? 1 : 0;
        has_text_ = false;
      } else if (text[seen_] != '\r') {
        has_text_ = true;
      }
    }
    return count_;
  }

 private:
  std::size_t seen_ = 0, count_ = 0;
  bool has_text_ = false;
};

/// Waits until a program has ended, without taking it from the list of processes: its number stays its own.
bool ends_before(pid_t process, Clock::time_point deadline) {
  while (true) {
    siginfo_t info = {};
    if (waitid(P_PID, static_cast<id_t>(process), &info, WEXITED | WNOHANG | WNOWAIT) != 0) return true;
    if (info.si_pid == process) return true;
    if (Clock::now() >= deadline) return false;
    const timespec pause = {0, 1'000'000};
    nanosleep(&pause, nullptr);
  }
}

Clock::time_point after(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// Writes and reads what is ready, until all is said or a limit is reached.
class Conversation {
 public:
  Conversation(ChildStreams& streams, const std::string& input, const ChildLimits& limits)
      : in_(streams.in),
        out_(streams.out),
        err_(streams.err),
        input_(input),
        limits_(limits),
        deadline_(after(limits.seconds)) {}

  Clock::time_point deadline() const { return deadline_; }

  /// What a program that has ended said on its standard error.
  void hear_last_words(ChildResult& result) {
    constexpr int kMostReads = 64;
    for (int i = 0; i < kMostReads && err_.is_open() && read_some(err_, result.errors); ++i) forget(result);
  }

  /// Until both streams have ended: `exited`.
  ChildResult::End finish(ChildResult& result) {
    if (input_.empty()) in_.close();
    while (out_.is_open() || err_.is_open()) {
      if (const auto limit = step(result)) return *limit;
      if (written_ == input_.size()) in_.close();
    }
    return ChildResult::End::exited;
  }

  /// Until there are so many lines: `answered`, or the output has ended before: `exited`.
  ChildResult::End ask(ChildResult& result, std::size_t lines) {
    LineCount count;
    read_some(out_, result.output);
    if (result.output.find_first_not_of("\r\n") != std::string::npos) return ChildResult::End::unasked;
    if (!in_.is_open()) return ChildResult::End::not_listening;
    while (count.in(result.output) < lines || (in_.is_open() && written_ < input_.size())) {
      if (!out_.is_open()) return ChildResult::End::exited;
      if (const auto limit = step(result)) return in_.is_open() ? *limit : ChildResult::End::not_listening;
      // One that ends closes its input, too: a moment later it is seen which it is.
      if (!in_.is_open()) deadline_ = std::min(deadline_, after(kMoment));
    }
    read_some(out_, result.output);  // lines too many, told now rather than with the next batch
    return ChildResult::End::answered;
  }

 private:
  static constexpr std::size_t kErrorsKept = 4096;

  /// @returns the limit that is reached
  std::optional<ChildResult::End> step(ChildResult& result) {
    const int left = milliseconds_left();
    if (left <= 0) return ChildResult::End::timed_out;
    // That the program closes its input is told whether or not there is more to write.
    const short writing = written_ < input_.size() ? POLLOUT : 0;
    std::array<pollfd, 3> events = {pollfd{out_.get(), POLLIN, 0}, pollfd{err_.get(), POLLIN, 0},
                                    pollfd{in_.get(), writing, 0}};
    if (poll(events.data(), events.size(), left) < 0 && errno != EINTR) return ChildResult::End::timed_out;
    if (events[0].revents != 0) read_some(out_, result.output);
    if (events[1].revents != 0) read_some(err_, result.errors);
    if ((events[2].revents & POLLERR) != 0) in_.close();
    if ((events[2].revents & POLLOUT) != 0 && in_.is_open()) write_some();
    if (result.output.size() > limits_.output_bytes) return ChildResult::End::too_much_output;
    forget(result);
    return {};
  }

  static void forget(ChildResult& result) {
    if (result.errors.size() > 2 * kErrorsKept) result.errors.erase(0, result.errors.size() - kErrorsKept);
  }

  int milliseconds_left() const {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now()).count();
    constexpr long kLongest = 1000;
    return static_cast<int>(std::clamp<long>(left, 0, kLongest));
  }

  /// @returns whether there was something
  static bool read_some(Descriptor& from, std::string& text) {
    std::array<char, 65536> buffer;
    const ssize_t count = ::read(from.get(), buffer.data(), buffer.size());
    if (count > 0) text.append(buffer.data(), static_cast<std::size_t>(count));
    if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) from.close();
    return count > 0;
  }

  void write_some() {
    const ssize_t count = ::write(in_.get(), input_.data() + written_, input_.size() - written_);
    if (count > 0) written_ += static_cast<std::size_t>(count);
    // A program that does not read all of its input may be right nevertheless.
    if (count < 0 && errno != EINTR && errno != EAGAIN) in_.close();
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

ChildProcess::ChildProcess(const std::vector<std::string>& run) {
  Pipe in, out, err;
  if (!in.reading.is_open() || !out.reading.is_open() || !err.reading.is_open()) {
    problem_ = errno;
    return;
  }
  const NoPipeSignal guard;
  pid_t process = 0;
  problem_ = spawn(run, guard.before(), in, out, err, process);
  if (problem_ != 0) return;
  process_ = process;
  for (const Descriptor* ours : {&in.writing, &out.reading, &err.reading})
    fcntl(ours->get(), F_SETFL, O_NONBLOCK);
  streams_ = std::make_unique<ChildStreams>(
      ChildStreams{std::move(in.writing), std::move(out.reading), std::move(err.reading)});
}

ChildProcess::~ChildProcess() {
  if (process_ == 0) return;
  constexpr double kGrace = 2.0;  // s
  streams_->in.close();
  ends_before(process_, after(kGrace));
  kill();
}

void ChildProcess::kill() {
  ChildResult ignored;
  if (process_ != 0) end(ignored, false);
}

/// Kills what is left of the group. @param in_time whether the program has ended by itself
void ChildProcess::end(ChildResult& result, bool in_time) {
  ::kill(-process_, SIGKILL);
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
  process_ = 0;
  streams_.reset();
  if (!in_time) return;
  if (WIFSIGNALED(status)) {
    result.end = ChildResult::End::killed;
    result.code = WTERMSIG(status);
  } else {
    result.end = ChildResult::End::exited;
    result.code = WEXITSTATUS(status);
  }
}

ChildResult ChildProcess::finish(const std::string& input, const ChildLimits& limits) {
  ChildResult result;
  result.code = problem_;
  if (process_ == 0) return result;
  const NoPipeSignal guard;
  Conversation conversation(*streams_, input, limits);
  result.end = conversation.finish(result);
  const bool in_time =
      result.end == ChildResult::End::exited && ends_before(process_, conversation.deadline());
  if (result.end == ChildResult::End::exited) result.end = ChildResult::End::timed_out;
  end(result, in_time);
  return result;
}

ChildResult ChildProcess::ask(const std::string& input, std::size_t lines, const ChildLimits& limits) {
  ChildResult result;
  result.code = problem_;
  if (process_ == 0) return result;
  const NoPipeSignal guard;
  Conversation conversation(*streams_, input, limits);
  result.end = conversation.ask(result, lines);
  if (result.end == ChildResult::End::answered) return result;
  // One that ends closes its output a moment before.
  const bool in_time = result.end == ChildResult::End::exited &&
                       ends_before(process_, std::min(conversation.deadline(), after(kMoment)));
  conversation.hear_last_words(result);
  if (result.end == ChildResult::End::exited) result.end = ChildResult::End::closed;
  end(result, in_time);
  return result;
}

}  // namespace samara::codebooks
