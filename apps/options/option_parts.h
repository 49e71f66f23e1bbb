#pragma once

#include <charconv>
#include <limits>
#include <memory>
#include <string>
#include <system_error>
#include <type_traits>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/arguments.h"

/// What options of several commands have in common.
namespace samara::apps {

inline constexpr const char* kAssignments = "NAME=VALUE, SI or with a unit: C_D=1.2, \"v(0)=10 cm/s\"";

inline constexpr const char* kTimes =
    "times, s or with a unit: 0.3, a list 0.1,0.2, or FROM:STEP:TO as in 0:0.1:0.5; default: 11 from begin "
    "to end";

inline constexpr const char* kAnswerFile = "file for the answer; stdout if not given";

inline constexpr const char* kJsonOfFile = "print one JSON object about the file";

inline constexpr const char* kJson = "print one JSON object";

inline constexpr const char* kBody = "ellipsoid, disc or plate, with --size; or a mesh: OBJ, STL, PLY";

/// "2.5" and "1e3" are no whole numbers, and digits beyond the type are too large: in words, where the parser
/// would only say that it could not convert, or take the largest number without a word.
template <class T = int>
CLI::Validator whole_number() {
  return CLI::Validator(
      [](const std::string& text) {
        T value = 0;
        const auto [rest, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (problem == std::errc() && rest == text.data() + text.size()) return std::string();
        return fmt::format("is {}, expected a whole number {}of at most {}", text.empty() ? "empty" : text,
                           std::is_unsigned_v<T> ? "from 0 on, " : "", std::numeric_limits<T>::max());
      },
      "");
}

/// Once the command is called, `run` of its values is what the call is for.
template <class T>
void on_call(CLI::App& command, Arguments& arguments, std::shared_ptr<T> values, int (*run)(const T&)) {
  command.callback([&arguments, values, run] { arguments.run = [values, run] { return run(*values); }; });
}

/// What is drawn: --body, --size, --unit.
void add_shown_words(CLI::App& command, ShownWords& words);

/// How large and heavy a body is, and how its added mass is found.
void add_body_words(CLI::App& command, BodyWords& words, bool required);

/// Realisations in turbulence: all but what they share with a single trajectory.
void add_cloud_words(CLI::App& command, CloudWords& words);

}  // namespace samara::apps
