#include "options/motion_arguments.h"

#include <memory>

#include "options/option_parts.h"

namespace samara::apps {

namespace {

void add_sweep(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<SweepArguments>();
  CLI::App* command =
      app.add_subcommand("sweep", "the same fall at many points of a box: features and patterns");
  command->add_option("PLAN", values->plan, "what is swept, TOML")->required();
  command->add_option("-o,--output", values->output, "sweep file to write, HDF5")->required();
  CLI::Option* resume = command->add_flag(
      "--resume", values->resume,
      "only go on where a sweep of the same plan and output stopped, which is done anyway if there is one");
  command->add_flag("--fresh", values->fresh, "begin anew, and drop what an earlier sweep has left")
      ->excludes(resume);
  command->add_flag("--json", values->json, kJson);
  command->callback([&arguments, values] { arguments.sweep = *values; });
}

void add_database(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<DatabaseArguments>();
  CLI::App* command = app.add_subcommand(
      "database",
      "the falls of a sweep as segments to go on from: what can follow what, and how often it does");
  command->add_option("SWEEP", values->sweep, "sweep, HDF5")->required();
  command->add_option("-o,--output", values->output, "database of motions to write, HDF5")->required();
  command->add_flag("--json", values->json, kJson);
  command->callback([&arguments, values] { arguments.database = *values; });
}

void add_patterns(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<PatternsArguments>();
  CLI::App* command = app.add_subcommand(
      "patterns",
      "of a sweep: counts, map, clusters, landing; of captures: labels window by window, transitions");
  command->add_option("INPUTS", values->inputs, "one sweep (HDF5), or captures: tables, sidecars")
      ->required();
  command->add_option("--clusters", values->clusters, "of a sweep, beside the rule")->capture_default_str();
  command->add_option("--sidecar", values->sidecar, "of every table; default: those beside them");
  command->add_option("--length", values->length, "of the body, m or with a unit: \"7 cm\"");
  command->add_option(
      "--body", values->body,
      "model of the body of captures: its length, and its place in the diagram of the report");
  command
      ->add_option("--set", values->set,
                   "of the body, or of the point to clamp: NAME=VALUE, SI or with a unit; may be repeated")
      ->allow_extra_args(false);
  command
      ->add_option("--threshold", values->thresholds,
                   "of captures: NAME=VALUE, a threshold of the rule; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--report", values->report,
                      "page for the browser to write: diagram, map, features, chain");
  command->add_option("--labels", values->labels,
                      "a person's labels: a table with capture, first_frame, last_frame, label");
  command
      ->add_option("--class", values->classes,
                   "what a word of the labels means, WORD=PATTERN+PATTERN; may be repeated. Default: names "
                   "of patterns")
      ->allow_extra_args(false);
  command->add_option("--draw", values->draw,
                      "of a sweep: points of the box that lead to this PATTERN, as a table");
  command->add_option("--count", values->count, "of draws, 1");
  command->add_option("--seed", values->seed, "of draws, 1");
  command->add_option("--clamp", values->clamp,
                      "of a sweep: the point of --set, moved to where it leads to this PATTERN");
  command->add_option("--release", values->release, "of the sweep that --draw and --clamp are of, from 0");
  command->add_option("-o,--output", values->output, kAnswerFile);
  command->add_flag("--json", values->json, kJson);
  command->callback([&arguments, values] { arguments.patterns = *values; });
}

void add_regime(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<RegimeArguments>();
  CLI::App* command =
      app.add_subcommand("regime", "Re, the three I*, and where a body stands in the measured phase diagram");
  command->add_option("MODEL", values->model, "name of a model of a falling body, or a file")->required();
  command->add_option("--set", values->set, "NAME=VALUE, SI or with a unit")->allow_extra_args(false);
  command->add_option("-o,--output", values->output, kAnswerFile);
  command->add_flag("--json", values->json, kJson);
  command->add_option("--sweep", values->sweep,
                      "a sweep of the model: which shares of its falls near this body have which pattern");
  command->callback([&arguments, values] { arguments.regime = *values; });
}

}  // namespace

void add_motion_commands(CLI::App& app, Arguments& arguments) {
  add_sweep(app, arguments);
  add_database(app, arguments);
  add_patterns(app, arguments);
  add_regime(app, arguments);
}

}  // namespace samara::apps
