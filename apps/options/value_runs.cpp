#include "options/value_runs.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>

#include <CLI/CLI.hpp>

namespace samara::apps {

namespace {

enum class ValueKind { number, name, assignment, file };

struct RunOption {
  std::string_view name;
  ValueKind kind;
};

constexpr std::array<RunOption, 8> kRunOptions = {{{"--at", ValueKind::number},
                                                   {"--size", ValueKind::number},
                                                   {"--quantiles", ValueKind::number},
                                                   {"--outputs", ValueKind::name},
                                                   {"--model", ValueKind::name},
                                                   {"--turbulence", ValueKind::assignment},
                                                   {"--left-out", ValueKind::file},
                                                   {"--train", ValueKind::file}}};

const RunOption* find_run(std::string_view option) {
  const auto* const found = std::ranges::find(kRunOptions, option, &RunOption::name);
  return found == kRunOptions.end() ? nullptr : found;
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// "0.1", "-.5 m", "+3": a sign, a point, a digit.
bool begins_as_number(std::string_view word) {
  if (!word.empty() && (word.front() == '-' || word.front() == '+')) word.remove_prefix(1);
  if (!word.empty() && word.front() == '.') word.remove_prefix(1);
  return !word.empty() && is_digit(word.front());
}

bool is_there(const std::string& word) {
  std::error_code ignored;
  return std::filesystem::exists(word, ignored);
}

/// @param takes_files whether files that follow are surely no inputs
bool continues(ValueKind kind, const std::string& word, bool takes_files) {
  if (word.empty() || is_option(word)) return false;
  switch (kind) {
    case ValueKind::number:
      return begins_as_number(word) && !is_there(word);
    case ValueKind::name:
      return word.find_first_of("./") == std::string::npos && !is_there(word);
    case ValueKind::assignment:
      return word.find('=') != std::string::npos;
    case ValueKind::file:
      return takes_files;
  }
  return false;
}

/// Whether the next word is its value.
bool takes_value(const CLI::App& command, const std::string& word) {
  if (word.find('=') != std::string::npos) return false;
  const CLI::Option* option = command.get_option_no_throw(word);
  return option != nullptr && option->get_items_expected_max() > 0;
}

}  // namespace

bool is_option(std::string_view word) {
  return word.size() > 1 && word.front() == '-' && !begins_as_number(word);
}

const CLI::App* command_of(const CLI::App& app, const std::string& name) {
  for (const CLI::App* command : app.get_subcommands({}))
    if (command->get_name() == name) return command;
  return nullptr;
}

bool takes_run(const std::string& option) {
  return find_run(option) != nullptr;
}

std::vector<std::string> with_rows_taken_apart(const CLI::App& app, const std::vector<std::string>& words) {
  std::vector<std::string> apart;
  const CLI::App* command = nullptr;
  bool after_inputs = false;
  for (std::size_t k = 0; k < words.size(); ++k) {
    const std::string& word = words[k];
    if (word == "--") {
      apart.insert(apart.end(), words.begin() + static_cast<std::ptrdiff_t>(k), words.end());
      break;
    }
    if (command == nullptr && !is_option(word)) {
      command = command_of(app, word);
      apart.push_back(word);
      continue;
    }
    const CLI::App& known = command == nullptr ? app : *command;
    const RunOption* run = command != nullptr ? find_run(word) : nullptr;
    if (run != nullptr && known.get_option_no_throw(word) == nullptr) run = nullptr;
    if (run == nullptr) {
      apart.push_back(word);
      if (is_option(word)) {
        if (takes_value(known, word) && k + 1 < words.size()) apart.push_back(words[++k]);
      } else {
        after_inputs = true;
      }
      continue;
    }
    // Inputs stand before the row, or after a "--" that ends it.
    const auto behind = words.begin() + static_cast<std::ptrdiff_t>(k);
    const bool takes_files = after_inputs || std::find(behind, words.end(), "--") != words.end();
    // The first value may begin with a sign that is no number's; the parser says what it thinks of it.
    bool is_first = true;
    while (k + 1 < words.size() &&
           (is_first ? !is_option(words[k + 1]) : continues(run->kind, words[k + 1], takes_files))) {
      const std::string& value = words[++k];
      if (value.empty()) {
        apart.insert(apart.end(), {word, value});
      } else {
        apart.push_back(word + "=" + value);
      }
      is_first = false;
    }
    if (is_first) apart.push_back(word);  // without a value, which the parser refuses
  }
  return apart;
}

}  // namespace samara::apps
