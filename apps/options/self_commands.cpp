#include "options/self_commands.h"

#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/completion.h"
#include "options/manual.h"
#include "options/option_tree.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/models/fields/field_model.h"
#include "samara/models/laws/registry.h"

namespace samara::apps {

namespace {

std::vector<std::string> all_model_names() {
  std::vector<std::string> names = models::model_names();
  const std::vector<std::string> fields = models::field_model_names();
  names.insert(names.end(), fields.begin(), fields.end());
  return names;
}

/// The parser would give the help of the command that was called.
std::string own_help(const CLI::App& app) {
  return app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal);
}

std::string help_answer(const CLI::App& app, const std::vector<CommandWords>& tree, const SelfWords& words) {
  if (words.json) return tree_json(tree);
  if (words.topic.empty()) return words.man ? manual_page(nullptr, tree) : own_help(app);
  std::vector<std::string> known;
  for (const CommandWords& command : tree) {
    known.push_back(command.name);
    if (command.name != words.topic) continue;
    if (words.man) return manual_page(&command, tree);
    return app.get_subcommand(command.name)->help(app.get_name());
  }
  throw ArgumentError(fmt::format("\"{}\" is not a command{}", words.topic, suggestion(words.topic, known)));
}

}  // namespace

void add_self(CLI::App& app, SelfWords& words) {
  CLI::App* help =
      app.add_subcommand("help", "the help of a command, also as a page for man; all of them as JSON");
  help->add_option("COMMAND", words.topic, "any; all if not given");
  CLI::Option* json =
      help->add_flag("--json", words.json, "all commands and their options as one JSON object");
  help->add_flag("--man", words.man, "as a page for man")->excludes(json);
  CLI::App* completion =
      app.add_subcommand("completion", "what a shell needs to complete commands, options and names");
  CLI::Option* shell = completion->add_option("SHELL", words.shell, "which shell")
                           ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  completion
      ->add_option("--names", words.names,
                   "print what may be --set of a model, a codebook or a plan, one name a line")
      ->excludes(shell);
}

std::string answer_of(const CLI::App& app, const SelfWords& words) {
  const std::vector<CLI::App*> called = app.get_subcommands();
  if (called.empty()) return "";
  const std::string name = called.front()->get_name();
  if (name == "help") return help_answer(app, option_tree(app), words);
  if (name != "completion" || !words.names.empty()) return "";
  if (words.shell.empty()) throw ArgumentError("completion of which shell? bash, zsh or fish was expected");
  return completion_script(words.shell, option_tree(app), all_model_names());
}

}  // namespace samara::apps
