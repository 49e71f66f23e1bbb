#pragma once

#include <string>
#include <vector>

/// All commands with their options, as plain words: for the help, the completion of shells, the manual
/// pages and programs that call the command.
namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace samara::apps {

struct OptionWords {
  std::vector<std::string> names;    ///< "-o", "--output"; of an input its name, "BOOK"
  std::string value;                 ///< what follows it: "TEXT", "INT", ..; empty: nothing
  std::vector<std::string> choices;  ///< all that the value may be; empty: anything
  bool several = false;              ///< one or more values may follow it in a row
  bool repeats = false;              ///< it may be given again
  bool required = false;
  std::string default_value;
  std::string text, group;
};

struct CommandWords {
  std::string name, summary;
  std::vector<OptionWords> inputs, options;
};

OptionWords words_of(const CLI::Option& option);
/// In the order in which the help has them.
std::vector<CommandWords> option_tree(const CLI::App& app);

}  // namespace samara::apps
