#include "options/arguments.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/build_facts.h"
#include "options/commands.h"
#include "options/help_text.h"
#include "options/self_commands.h"
#include "options/value_runs.h"
#include "options/wrong_calls.h"
#include "samara/base/errors.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

/// Whatever an option collects, one word each: see options/value_runs.h.
void take_one_word_each(CLI::App& command) {
  for (CLI::Option* option : command.get_options())
    if (!option->get_positional()) option->allow_extra_args(false);
}

/// `--config "$CONFIG"` with a variable that is not set must not mean that there is no config, nor `"$BOOK"` a file.
void refuse_empty(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (option->get_items_expected_max() == 0) continue;
    option->check(CLI::Validator(
        [](const std::string& text) { return text.empty() ? std::string("is empty") : std::string(); }, ""));
  }
}

/// A value too many after an option would pass for one more input. So the inputs of a command stand in one
/// row, which no option with values interrupts.
void check_row(const CLI::App& command) {
  std::map<const CLI::Option*, std::size_t> counts;
  std::string interrupted_by;
  bool has_inputs = false;
  for (const CLI::Option* option : command.parse_order()) {
    const std::size_t index = counts[option]++;
    if (!option->get_positional()) {
      if (has_inputs && option->get_items_expected_max() > 0) interrupted_by = option->get_name();
      continue;
    }
    if (!interrupted_by.empty()) {
      throw ArgumentError(fmt::format(
          "\"{}\" stands after {}, apart from the inputs before it; all inputs in one row were expected",
          option->results().at(index), interrupted_by));
    }
    has_inputs = true;
  }
}

/// Without a word: the help, but nothing was done.
Arguments nothing_asked(const CLI::App& app) {
  explain_on_stderr(app.help());
  Arguments arguments;
  arguments.exit_code = kWrongCall;
  return arguments;
}

}  // namespace

Arguments parse(int argc, const char* const* argv) {
  Arguments arguments;
  CLI::App app(
      "Parametric solution codebooks of bodies moving in a fluid.\n"
      "Answers go to stdout, or with -o to a file; everything else goes to stderr. Exit codes: 0 done, 1 "
      "internal failure, 2 "
      "wrong call, 3 bad input file, 4 tolerance or convergence missed, 5 query outside the box, 130 "
      "interrupted.",
      "samara");
  app.formatter(help_formatter());
  app.set_version_flag("-V,--version", version_text());
  app.set_help_flag("-h,--help", "print this and exit");
  app.require_subcommand(1);
  app.add_option("--model-library", arguments.model_libraries,
                 "shared library of models of your own, before the command; may be repeated");
  SelfWords self;
  add_commands(app, arguments);
  add_self(app, self);
  take_one_word_each(app);
  for (CLI::App* command : app.get_subcommands({})) {
    take_one_word_each(*command);
    refuse_empty(*command);
    command->add_flag("-q,--quiet", arguments.quiet, "say nothing but errors");
    command->add_flag("-v,--verbose", arguments.verbose, "say more: each stage, every note, time and memory");
  }
  if (argc < 2) return nothing_asked(app);
  check_command(app, {argv + 1, argv + argc});
  try {
    std::vector<std::string> words = with_rows_taken_apart(app, {argv + 1, argv + argc});
    std::ranges::reverse(words);  // as the parser takes them
    app.parse(std::move(words));
    for (const CLI::App* command : app.get_subcommands()) check_row(*command);
    const std::string answer = answer_of(app, self);
    if (!answer.empty()) {
      print(answer);
      arguments.exit_code = kDone;
    }
    if (!self.names.empty()) arguments.run = [names = self.names] { return print_names(names); };
  } catch (const CLI::Success& help) {
    std::ostringstream text;
    arguments.exit_code = app.exit(help, text, text);
    print(text.str());
  } catch (const CLI::ParseError& error) {
    complain(sentence_of(error, app));
    arguments.exit_code = kWrongCall;
  }
  return arguments;
}

}  // namespace samara::apps
