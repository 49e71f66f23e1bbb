#include "terminal.h"

#include <csignal>
#include <cstdio>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "samara/base/names.h"
#include "samara/models/checks/parameter_warnings.h"

namespace samara::apps {

namespace {

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

void complain(const std::string& sentence) {
  clear_progress();
  say(fmt::format("samara: {}\n", printable(sentence)));
}

void warn(const std::string& sentence) {
  clear_progress();
  say(fmt::format("samara: warning: {}\n", printable(sentence)));
}

void warn_of_parameters(const models::Model& model, const std::map<std::string, double>& values) {
  for (const std::string& sentence : models::parameter_warnings(model, values)) warn(sentence);
}

void narrate(const std::string& line) {
  clear_progress();
  say(fmt::format("{}\n", printable(line)));
}

ProgressCallback progress_line() {
  if (isatty(STDERR_FILENO) == 0) return {};
  return [](const Progress& progress) {
    say(fmt::format("\r\033[K{} {:.0f} %", progress.stage, 100.0 * progress.fraction));
    return true;
  };
}

void clear_progress() {
  if (isatty(STDERR_FILENO) != 0) say("\r\033[K");
}

}  // namespace samara::apps
