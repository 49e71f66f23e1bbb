#include "terminal/terminal.h"

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <string>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/models/checks/parameter_warnings.h"
#include "terminal/interrupts.h"

namespace samara::apps {

namespace {

Verbosity said = Verbosity::usual;

/// Words are lost where stderr is closed, full, or a pipe whose reader has gone: neither an answer nor an
/// exit code may be lost with them.
void say(const std::string& text) {
  struct sigaction ignored = {}, before = {};
  ignored.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &ignored, &before);
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
  sigaction(SIGPIPE, &before, nullptr);
}

}  // namespace

void hold_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) < 0)
      ::open("/", O_PATH | O_DIRECTORY);  // takes the lowest number that is free
  }
}

void require_stdin(const std::string& expected) {
  struct stat status = {};
  if (::fstat(STDIN_FILENO, &status) != 0 || S_ISDIR(status.st_mode))
    throw InputError("stdin", fmt::format("is closed, or a directory; expected {}", expected));
}

void set_verbosity(Verbosity verbosity) {
  said = verbosity;
}

bool is_verbose() {
  return said == Verbosity::verbose;
}

void complain(const std::string& sentence) {
  clear_progress();
  say(fmt::format("samara: {}\n", printable(sentence)));
}

void warn(const std::string& sentence) {
  if (said == Verbosity::quiet) return;
  clear_progress();
  say(fmt::format("samara: warning: {}\n", printable(sentence)));
}

void warn_of_parameters(const models::Model& model, const std::map<std::string, double>& values) {
  for (const std::string& sentence : models::parameter_warnings(model, values)) warn(sentence);
}

void narrate(const std::string& line) {
  if (said == Verbosity::quiet) return;
  clear_progress();
  say(fmt::format("{}\n", printable(line)));
}

void explain_on_stderr(const std::string& lines) {
  say(lines);
}

namespace {

std::string duration_text(double seconds) {
  const long whole = std::lround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

/// Says how far work is, now and then.
class ProgressReport {
 public:
  explicit ProgressReport(bool overwrites) : overwrites_(overwrites) {}

  bool operator()(const Progress& progress) {
    const Clock::time_point now = Clock::now();
    const bool begins = progress.stage != stage_;
    if (begins || progress.fraction < fraction_) stage_begin_ = now;
    stage_ = progress.stage;
    fraction_ = progress.fraction;
    if (said == Verbosity::quiet) return !is_interrupted();
    const bool is_told = begins && !overwrites_ && is_verbose();
    if (is_told || now - told_ >= (overwrites_ ? kRedraw : kHeartbeat)) tell(now);
    return !is_interrupted();
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kRedraw{50}, kHeartbeat{30'000};

  void tell(Clock::time_point now) {
    const auto since = [&](Clock::time_point then) {
      return std::chrono::duration<double>(now - then).count();
    };
    std::string line =
        fmt::format("{} {:.0f} %, {}", stage_, 100.0 * fraction_, duration_text(since(begin_)));
    constexpr double kToldApart = 0.02;  // earlier, what is left is a guess
    if (fraction_ > kToldApart && since(stage_begin_) > 1.0)
      line += fmt::format(", {} of this stage left",
                          duration_text(since(stage_begin_) * (1.0 / fraction_ - 1.0)));
    say(overwrites_ ? fmt::format("\r\033[K{}", line) : line + "\n");
    told_ = now;
  }

  bool overwrites_;
  Clock::time_point begin_ = Clock::now(), told_ = overwrites_ ? Clock::time_point() : begin_,
                    stage_begin_ = begin_;
  std::string stage_;
  double fraction_ = 0.0;
};

}  // namespace

ProgressCallback progress_line() {
  return ProgressReport(isatty(STDERR_FILENO) != 0);
}

void clear_progress() {
  if (isatty(STDERR_FILENO) != 0) say("\r\033[K");
}

}  // namespace samara::apps
