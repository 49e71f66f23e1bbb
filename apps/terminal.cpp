#include "terminal.h"

#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

#include "samara/base/names.h"
#include "samara/models/unit_warnings.h"

namespace samara::apps {

void complain(const std::string& sentence) {
  clear_progress();
  fmt::print(stderr, "samara: {}\n", printable(sentence));
}

void warn(const std::string& sentence) {
  clear_progress();
  fmt::print(stderr, "samara: warning: {}\n", printable(sentence));
}

void warn_of_units(const models::Model& model, const std::map<std::string, double>& values) {
  for (const std::string& sentence : models::unit_warnings(model, values)) warn(sentence);
}

void narrate(const std::string& line) {
  clear_progress();
  fmt::print(stderr, "{}\n", printable(line));
}

ProgressCallback progress_line() {
  if (isatty(STDERR_FILENO) == 0) return {};
  return [](const Progress& progress) {
    fmt::print(stderr, "\r\033[K{} {:.0f} %", progress.stage, 100.0 * progress.fraction);
    std::fflush(stderr);
    return true;
  };
}

void clear_progress() {
  if (isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\r\033[K");
}

}  // namespace samara::apps
