#pragma once

#include <string>

namespace CLI {
class App;
}

namespace samara::apps {

/// What was typed of the commands that speak of the command itself, help and completion.
struct SelfWords {
  std::string topic;
  bool json = false, man = false;
  std::string shell, names;
};

void add_self(CLI::App& app, SelfWords& words);

/// The answer of help, or a script of completion; empty for other commands, and where --names asks for names.
/// @throws ArgumentError for an unknown command, or where no shell is named
std::string answer_of(const CLI::App& app, const SelfWords& words);

}  // namespace samara::apps
