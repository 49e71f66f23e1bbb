#include "options/planning_arguments.h"

#include <memory>

#include "options/option_parts.h"

namespace samara::apps {

namespace {

void add_ghost(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<GhostArguments>();
  CLI::App* command = app.add_subcommand(
      "ghost", "the invisible force of a motion: what a body would need besides all that its model knows");
  command->add_option("MODEL", values->model, "name of a model of a falling body, or a file")->required();
  command->add_option("PATH", values->path, "poses at frames: a table (as simulate writes it), or a sidecar")
      ->required();
  command->add_option("--set", values->set, "NAME=VALUE, SI or with a unit; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--coefficients", values->coefficients,
                      "course of coefficients that the motion was made with (a codebook over time)");
  command
      ->add_option("--box", values->box,
                   "NAME=FROM..TO, a coefficient that may be what hides the force best; may be repeated")
      ->allow_extra_args(false);
  command->add_option("-o,--output", values->output, "sizes of force and torque frame by frame, CSV");
  command->add_flag("--json", values->json, "print one JSON object");
  command->callback([&arguments, values] { arguments.ghost = *values; });
}

void add_synthesize(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<SynthesizeArguments>();
  CLI::App* command = app.add_subcommand("synthesize",
                                         "a fall that follows a sketch, comes down at a place, or swings and "
                                         "turns in a given order, by coefficients "
                                         "that change on the way");
  command->add_option("PLAN", values->plan, "what the fall is to do, TOML")->required();
  command->add_option("-o,--output", values->output, "motion to write: .glb, .usda, or .csv of states")
      ->required();
  command->add_option("--course", values->course,
                      "its coefficients over time to write, HDF5: what simulate --coefficients replays");
  command->add_option("--csv", values->csv, "its states to write");
  command->add_option("--picture", values->picture,
                      "path over the sketch, coefficients, invisible force: SVG to write");
  command->add_option(
      "--report", values->report,
      "page for the browser to write: path, coefficients, kinds asked and got, invisible force");
  CLI::Option* resume = command->add_flag(
      "--resume", values->resume,
      "only go on where a search of the same plan and output stopped, which is done anyway if there is one");
  command->add_flag("--fresh", values->fresh, "begin anew, and drop what an earlier search has left")
      ->excludes(resume);
  add_shown_words(*command, values->body);
  command->add_flag("--json", values->json, "print one JSON object");
  command->callback([&arguments, values] { arguments.synthesize = *values; });
}

}  // namespace

void add_planning_commands(CLI::App& app, Arguments& arguments) {
  add_ghost(app, arguments);
  add_synthesize(app, arguments);
}

}  // namespace samara::apps
