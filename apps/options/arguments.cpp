#include "options/arguments.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/build_facts.h"
#include "options/flow_arguments.h"
#include "options/help_text.h"
#include "options/motion_arguments.h"
#include "options/option_parts.h"
#include "options/planning_arguments.h"
#include "options/self_commands.h"
#include "options/value_runs.h"
#include "options/wrong_calls.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

void add_models(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<ModelsArguments>();
  CLI::App* command =
      app.add_subcommand("models", "models with parameters, units, defaults, sources, validity");
  command->add_option("NAME", values->model,
                      "explain this model only, or the equations of a file (MODEL.toml)");
  CLI::Option* json = command->add_flag("--json", values->json, kJson);
  command->add_flag("--check", values->check, "check its promises, and name the kinks of its law")
      ->excludes(json);
  command->add_option("-o,--output", values->output, kAnswerFile);
  on_call(command, arguments.models, values);
}

void add_plan(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<PlanArguments>();
  CLI::App* command = app.add_subcommand(
      "plan", "a plan to begin with, with comments, for a model: samara build takes it as it is");
  command
      ->add_option("MODEL", values->model,
                   "name of a model (samara models), or file with equations (MODEL.toml)")
      ->required();
  command->add_option("-o,--output", values->output, "file for the plan, TOML; stdout if not given");
  command->add_flag("--json", values->json, "print one JSON object: what the plan asks for, and its text");
  on_call(command, arguments.plan, values);
}

void add_build(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<BuildArguments>();
  CLI::App* command = app.add_subcommand("build", "builds and certifies the codebook of a plan");
  command->add_option("PLAN", values->plan, "plan, TOML; - for stdin")->required();
  command->add_option("-o,--output", values->output,
                      "codebook file to write, HDF5; needed but for --dry-run");
  command->add_option("--set", values->set,
                      "in place of what the plan says: NAME=VALUE fixes, NAME=FROM..TO frees, SI or with a "
                      "unit: C_D=0.8..1.4");
  command->add_option("--tolerance", values->tolerance, "relative, in place of the plan's");
  command->add_option("--threads", values->threads, "in place of the plan's; 0: as many as the machine has");
  CLI::Option* dry =
      command->add_flag("--dry-run", values->dry_run, "check the plan and say what would be built, no more");
  CLI::Option* resume = command->add_flag(
      "--resume", values->resume,
      "only go on where a build of the same plan and output stopped, which is done anyway if there is one");
  resume->excludes(dry);
  command->add_flag("--fresh", values->fresh, "begin anew, and drop what an earlier build has left")
      ->excludes(resume)
      ->excludes(dry);
  command->add_flag("--force", values->force, "replace the output also if it is no codebook");
  command->add_flag("--json", values->json, kJson);
  on_call(command, arguments.build, values);
}

void add_body(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<BodyArguments>();
  CLI::App* command =
      app.add_subcommand("body", "mass, inertia, added mass and scaling numbers of a body in a fluid");
  command->add_option("BODY", values->words.body, kBody)->required();
  add_body_words(*command, values->words, true);
  CLI::Option* viscosity = command->add_option("--viscosity", values->viscosity,
                                               "of the fluid, Pa s or with a unit: for the Reynolds number");
  CLI::Option* json = command->add_flag("--json", values->json, kJson);
  command->add_option("-o,--output", values->output, kAnswerFile);
  command->add_flag("--toml", values->toml, "print the lines of a plan of kirchhoff_body")
      ->excludes(json)
      ->excludes(viscosity);
  on_call(command, arguments.body, values);
}

void add_info(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<InfoArguments>();
  CLI::App* command = app.add_subcommand(
      "info", "axes, ranks, size, certificate and provenance of a codebook; loads and checks of a flow");
  command->add_option("BOOK", values->book, "codebook file, or flow file")->required();
  CLI::Option* json = command->add_flag("--json", values->json, kJson);
  command->add_flag("--plan", values->plan, "the plan that a codebook was built from, and nothing else")
      ->excludes(json);
  command->add_option("-o,--output", values->output, kAnswerFile);
  on_call(command, arguments.info, values);
}

void add_stats(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<StatsArguments>();
  CLI::App* command = app.add_subcommand("stats",
                                         "mean, deviation, Sobol' indices and quantiles of the outputs, over "
                                         "time, of inputs that are uniform over the "
                                         "box or distributed otherwise, as CSV or JSON");
  command->add_option("BOOK", values->book, "codebook file")->required();
  command
      ->add_option("--set", values->set,
                   "NAME=VALUE holds an input; NAME=FROM..TO, \"NAME=normal(MEAN, DEVIATION)\" and "
                   "\"NAME=lognormal(MEDIAN, DEVIATION OF THE LOGARITHM)\" say how it is distributed")
      ->allow_extra_args(false);
  command->add_option("--fit", values->fit,
                      "fit (samara fit -o FIT.json) whose coefficients are inputs, with its covariance");
  command->add_option("--quantiles", values->quantiles, "shares between 0 and 1: 0.05 0.5 0.95");
  command->add_option("--group", values->groups, "inputs to give indices of together: C_T,C_R")
      ->allow_extra_args(false);
  command->add_option("--draws", values->draws, "of quantiles, and of correlated inputs")
      ->capture_default_str()
      ->check(whole_number());
  command->add_option("--seed", values->seed, "of the draws, from 0")
      ->capture_default_str()
      ->check(whole_number<std::uint64_t>());
  command->add_option("-o,--output", values->output, kAnswerFile);
  command->add_flag("--json", values->json, kJson);
  on_call(command, arguments.stats, values);
}

void add_query(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<QueryArguments>();
  CLI::App* command =
      app.add_subcommand("query", "values of a codebook, and derivatives by every axis, as CSV or JSON");
  command->add_option("BOOK", values->book, "codebook file")->required();
  command->add_option("--set", values->set, kAssignments)->allow_extra_args(false);
  CLI::Option* at = command->add_option("--at", values->at, kTimes);
  command->add_option("--frames", values->frames, "so many times, equally spaced, in place of 11")
      ->check(whole_number())
      ->check(CLI::Range(2, 10000000))
      ->excludes(at);
  command->add_option(
      "--points", values->points,
      "table of points, CSV with a column for each coordinate (\"C_D,v(0)[cm/s]\"), or - for stdin: a row "
      "each; what no "
      "column names is --set, and without a column of the time each point is asked at all times");
  command->add_option("--until", values->until,
                      "11 times from 0 to this one, s or with a unit, also after the codebook's own: by its "
                      "windows, composed, where the initial state is free");
  command->add_option("--second", values->second,
                      "of --until: codebook of the same model and time for attitudes near upside down");
  command->add_flag("--gradient", values->gradient, "add the derivative of every output by every axis");
  command->add_flag("--clamp", values->clamp,
                    "take the nearest point of the box instead of refusing (exit code 5)");
  command->add_option(
      "-o,--output", values->output,
      "file for the answer, CSV or with --json JSON, or the motion of the body: .glb (glTF) or "
      ".usda; stdout if not given");
  add_shown_words(*command, values->body);
  command->add_flag("--json", values->json, kJson);
  on_call(command, arguments.query, values);
}

void add_export(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<ExportArguments>();
  CLI::App* command =
      app.add_subcommand("export", "a codebook for programs without Samara; fields of space, flows");
  command->add_option("BOOK", values->book, "codebook file, or flow file")->required();
  command
      ->add_option("--to", values->to,
                   "for whom: paraview (a field of space at chosen parameters, as VTK files), or flat (the "
                   "codebook as samara_eval.h reads it, a header in C for programs without any library)")
      ->required()
      ->check(CLI::IsMember({"paraview", "flat"}));
  command->add_option("--set", values->set, kAssignments)->allow_extra_args(false);
  command->add_option("--at", values->at, kTimes);
  command
      ->add_option("-o,--output", values->output,
                   "file to write: NAME.vtu for one time, NAME.pvd for several, with NAME_0000.vtu and so on "
                   "beside it; of a flow NAME.xdmf, which refers to the flow file; NAME.flat")
      ->required();
  command->add_flag("--json", values->json, kJsonOfFile);
  on_call(command, arguments.exported, values);
}

void add_validate(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<ValidateArguments>();
  CLI::App* command = app.add_subcommand("validate", "certifies a codebook again, on fresh points");
  command->add_option("BOOK", values->book, "codebook file")->required();
  command->add_option("--plan", values->plan,
                      "of a codebook of a command: the plan whose command is called; none that stands in a "
                      "codebook is ever executed");
  command
      ->add_option("--points", values->points,
                   "scrambled Sobol' points in the box; default: 2000, of a command what its plan says")
      ->check(whole_number())
      ->check(CLI::Range(1, 100000000));
  command->add_option("--seed", values->seed, "of the scrambling, from 0")
      ->capture_default_str()
      ->check(whole_number<std::uint64_t>());
  command->add_option("-o,--output", values->output, kAnswerFile);
  command->add_flag("--json", values->json, kJson);
  on_call(command, arguments.validate, values);
}

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

/// The option parser would only say that some command is needed.
void check_command(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2 || std::string_view(argv[1]).starts_with('-')) return;
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands({})) known.push_back(command->get_name());
  const std::string name = argv[1];
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  throw ArgumentError(fmt::format("\"{}\" is not a command{}", name, suggestion(name, known)));
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
  add_models(app, arguments);
  add_simulate(app, arguments);
  add_plan(app, arguments);
  add_build(app, arguments);
  add_info(app, arguments);
  add_stats(app, arguments);
  add_query(app, arguments);
  add_export(app, arguments);
  add_explore(app, arguments);
  add_plot(app, arguments);
  add_validate(app, arguments);
  add_fit(app, arguments);
  add_body(app, arguments);
  add_design(app, arguments);
  add_compare(app, arguments);
  add_follow(app, arguments);
  add_wind(app, arguments);
  add_flow(app, arguments);
  add_picture(app, arguments);
  add_motion_commands(app, arguments);
  add_planning_commands(app, arguments);
  add_self(app, self);
  take_one_word_each(app);
  for (CLI::App* command : app.get_subcommands({})) {
    take_one_word_each(*command);
    refuse_empty(*command);
    command->add_flag("-q,--quiet", arguments.quiet, "say nothing but errors");
    command->add_flag("-v,--verbose", arguments.verbose, "say more: each stage, every note, time and memory");
  }
  if (argc < 2) return nothing_asked(app);
  check_command(app, argc, argv);
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
    if (!self.names.empty()) arguments.names = NamesArguments{self.names};
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
