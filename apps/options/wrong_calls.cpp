#include "options/wrong_calls.h"

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/value_runs.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/text.h"

namespace samara::apps {

namespace {

const CLI::App& called(const CLI::App& app) {
  const std::vector<const CLI::App*> commands =
      app.get_subcommands([](const CLI::App* command) { return command->parsed(); });
  return commands.empty() ? app : *commands.front();
}

/// The text before and after the first `mark`; all of it before where there is none.
std::pair<std::string, std::string> parted(const std::string& text, const std::string& mark) {
  const std::size_t at = text.find(mark);
  if (at == std::string::npos) return {text, ""};
  return {text.substr(0, at), text.substr(at + mark.size())};
}

std::string is(const std::string& name, const std::string& value, const std::string& expected) {
  if (value.empty()) return fmt::format("{} is empty, expected {}", name, expected);
  return fmt::format("{} is {}, expected {}", name, in_quotes(value), expected);
}

std::vector<std::string> long_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// Of the words that the parser has left; a "--" is among them.
bool is_unknown_option(const std::string& word) {
  return is_option(word) && word != "--";
}

/// Words that no option and no input has taken.
std::string sentence_of_extras(const std::vector<std::string>& words, const CLI::App& command) {
  const std::vector<std::string> known = long_names(command);
  for (const std::string& word : words) {
    if (!is_unknown_option(word)) continue;
    const std::string name = word.substr(0, word.find('='));
    const std::string near = nearest_name(name, known);
    return fmt::format("{} has no option {}{}", command.get_name(), in_quotes(name),
                       near.empty() ? std::string() : fmt::format("; did you mean {}?", near));
  }
  const auto stray = std::ranges::find_if(words, [](const std::string& word) { return word != "--"; });
  return fmt::format("{} does not take {} as well", command.get_name(),
                     stray == words.end() ? std::string("more words") : in_quotes(*stray));
}

/// "NAME: REASON" of a value that a check refused.
std::string sentence_of_value(const std::string& said) {
  const auto [name, reason] = parted(said, ": ");
  if (reason.starts_with("is ")) return name + " " + reason;
  if (const auto [value, choices] = parted(reason, " not in {"); !choices.empty()) {
    std::string list = choices.substr(0, choices.find('}'));
    for (std::size_t at = list.find(','); at != std::string::npos; at = list.find(',', at + 2))
      list.replace(at, 1, ", ");
    return is(name, value, "one of " + list);
  }
  constexpr std::string_view kValue = "Value ";
  if (const auto [value, range] = parted(reason, " not in range "); !range.empty())
    return is(name, value.substr(kValue.size()), range);
  return said;
}

/// "Could not convert: NAME = VALUE".
std::string sentence_of_number(const std::string& said, const CLI::App& command) {
  const auto [name, value] = parted(parted(said, ": ").second, " = ");
  const CLI::Option* option = command.get_option_no_throw(name);
  const bool is_whole = option != nullptr && option->get_type_name().find("INT") != std::string::npos;
  return is(name, value, is_whole ? "a whole number" : "a number");
}

/// "NAME: At Most 1 required but received 2", or one of the sentences for too few.
std::string sentence_of_count(const std::string& said) {
  const auto [name, reason] = parted(said, ": ");
  if (!reason.starts_with("At Most ")) return name + " stands without a value, expected one after it";
  const std::string count = parted(reason, " received ").second;
  return fmt::format("{} is given {}, expected once", name, count == "2" ? "twice" : count + " times");
}

/// The command among the words, null where there is none.
const CLI::App* named_command(const CLI::App& app, std::span<const std::string> words) {
  for (const std::string& word : words)
    if (const CLI::App* command = command_of(app, word)) return command;
  return nullptr;
}

/// An option before the command that is none of the few that belong there.
std::string sentence_of_early_option(const std::string& name, const CLI::App& app, const CLI::App* command) {
  if (command != nullptr && command->get_option_no_throw(name) != nullptr)
    return fmt::format("{} stands before the command, expected behind it: samara {} {}", in_quotes(name),
                       command->get_name(), name);
  for (const CLI::App* other : app.get_subcommands([](const CLI::App*) { return true; }))
    if (other->get_option_no_throw(name) != nullptr)
      return fmt::format("{} stands before a command, expected behind one that has it, as in samara {} {}",
                         in_quotes(name), other->get_name(), name);
  const std::vector<std::string> here = long_names(app);
  const std::vector<std::string> behind = command == nullptr ? here : long_names(*command);
  std::string near = nearest_name(name, here);
  std::string place;
  if (near.empty()) {
    near = nearest_name(name, behind);
    place = ", behind the command";
  }
  return fmt::format("samara has no option {}{}", in_quotes(name),
                     near.empty() ? "; known before a command: " + join(here)
                                  : fmt::format("; did you mean {}{}?", near, place));
}

}  // namespace

void check_command(const CLI::App& app, const std::vector<std::string>& words) {
  for (std::size_t k = 0; k < words.size(); ++k) {
    const std::string& word = words[k];
    if (word.size() < 2 || word.front() != '-') {
      if (command_of(app, word) != nullptr) return;
      std::vector<std::string> known;
      for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        known.push_back(command->get_name());
      throw ArgumentError(fmt::format("{} is not a command{}", in_quotes(word), suggestion(word, known)));
    }
    const std::string name = word.substr(0, word.find('='));
    const CLI::Option* option = app.get_option_no_throw(name);
    if (option == nullptr)
      throw ArgumentError(
          sentence_of_early_option(name, app, named_command(app, std::span(words).subspan(k + 1))));
    if (option->get_items_expected_max() > 0 && name == word) ++k;
  }
}

std::string sentence_of(const CLI::ParseError& error, const CLI::App& app) {
  const CLI::App& command = called(app);
  const std::string said = error.what();
  const std::vector<std::string> extras = command.remaining();
  // What else is wrong may come from an option that there is not.
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr ||
      std::ranges::any_of(extras, is_unknown_option))
    return sentence_of_extras(extras, command);
  if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr) return sentence_of_value(said);
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) return sentence_of_count(said);
  if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr && said.starts_with("Could not convert"))
    return sentence_of_number(said, command);
  return said;
}

}  // namespace samara::apps
