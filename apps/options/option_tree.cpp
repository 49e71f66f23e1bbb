#include "options/option_tree.h"

#include <algorithm>

#include <CLI/CLI.hpp>

#include "options/value_runs.h"

namespace samara::apps {

namespace {

/// "TEXT:{paraview,flat}" is what the parser makes of a value that must be one of a list.
void read_type(const std::string& type, OptionWords& words) {
  const std::size_t open = type.find('{'), close = type.rfind('}');
  words.value = type.substr(0, type.find(':'));
  if (open == std::string::npos || close == std::string::npos) return;
  for (std::size_t begin = open + 1; begin < close;) {
    const std::size_t end = std::min(type.find(',', begin), close);
    words.choices.push_back(type.substr(begin, end - begin));
    begin = end + 1;
  }
}

}  // namespace

OptionWords words_of(const CLI::Option& option) {
  OptionWords words;
  words.text = option.get_description();
  words.group = option.get_group();
  words.required = option.get_required();
  words.default_value = option.get_default_str();
  const bool many = option.get_expected_max() >= CLI::detail::expected_max_vector_size;
  if (option.get_positional()) {
    words.names = {option.get_name(true, false)};
    words.several = many;
  } else {
    for (const std::string& name : option.get_snames()) words.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) words.names.push_back("--" + name);
    words.several = many && takes_run(words.names.back());
    words.repeats = many;
  }
  if (option.get_items_expected_max() > 0) read_type(option.get_type_name(), words);
  return words;
}

std::vector<CommandWords> option_tree(const CLI::App& app) {
  std::vector<CommandWords> tree;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_group().empty()) continue;  // hidden
    CommandWords words{
        .name = command->get_name(), .summary = command->get_description(), .inputs = {}, .options = {}};
    for (const CLI::Option* option : command->get_options())
      (option->get_positional() ? words.inputs : words.options).push_back(words_of(*option));
    tree.push_back(std::move(words));
  }
  return tree;
}

}  // namespace samara::apps
