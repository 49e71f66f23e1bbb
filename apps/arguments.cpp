#include "arguments.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <string_view>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "flow_arguments.h"
#include "motion_arguments.h"
#include "option_parts.h"
#include "output.h"
#include "planning_arguments.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/version.h"
#include "terminal.h"

namespace samara::apps {

namespace {

/// The licence of the whole is that of its strictest part.
std::string version_text() {
#ifdef SAMARA_HAS_SUITESPARSE
  constexpr const char* kGplParts = "UMFPACK and CHOLMOD of SuiteSparse, also within Ceres Solver";
#else
  constexpr const char* kGplParts = "SuiteSparse within Ceres Solver, where the distribution has built it so";
#endif
  return fmt::format(
      "samara {}\nlicence: BSD-3-Clause; linked with parts under the GPL ({}), the program as a whole under "
      "the GPL",
      version(), kGplParts);
}

void add_models(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<ModelsArguments>();
  CLI::App* command =
      app.add_subcommand("models", "models with parameters, units, defaults, sources, validity");
  command->add_option("NAME", values->model,
                      "explain this model only, or the equations of a file (MODEL.toml)");
  CLI::Option* json = command->add_flag("--json", values->json, "print one JSON object");
  command->add_flag("--check", values->check, "check its promises, and name the kinks of its law")
      ->excludes(json);
  on_call(command, arguments.models, values);
}

void add_build(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<BuildArguments>();
  CLI::App* command = app.add_subcommand("build", "builds and certifies the codebook of a plan");
  command->add_option("PLAN", values->plan, "plan, TOML")->required();
  command->add_option("-o,--output", values->output, "codebook file to write, HDF5")->required();
  CLI::Option* resume = command->add_flag(
      "--resume", values->resume,
      "only go on where a build of the same plan and output stopped, which is done anyway if there is one");
  command->add_flag("--fresh", values->fresh, "begin anew, and drop what an earlier build has left")
      ->excludes(resume);
  command->add_flag("--force", values->force, "replace the output also if it is no codebook");
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
  CLI::Option* json = command->add_flag("--json", values->json, "print one JSON object");
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
  command->add_flag("--json", values->json, "print one JSON object");
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
  command->add_flag("--json", values->json, "print one JSON object");
  on_call(command, arguments.stats, values);
}

void add_query(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<QueryArguments>();
  CLI::App* command =
      app.add_subcommand("query", "values of a codebook, and derivatives by every axis, as CSV or JSON");
  command->add_option("BOOK", values->book, "codebook file")->required();
  command->add_option("--set", values->set, kAssignments)->allow_extra_args(false);
  command->add_option("--at", values->at, "times, s or with a unit; default: 11 from begin to end");
  command->add_option("--until", values->until,
                      "11 times from 0 to this one, s or with a unit, also after the codebook's own: by its "
                      "windows, composed, where the initial state is free");
  command->add_flag("--gradient", values->gradient, "add the derivative of every output by every axis");
  command->add_flag("--clamp", values->clamp,
                    "take the nearest point of the box instead of refusing (exit code 5)");
  command->add_option(
      "-o,--output", values->output,
      "file for the answer, CSV or with --json JSON, or the motion of the body: .glb (glTF) or "
      ".usda; stdout if not given");
  add_shown_words(*command, values->body);
  command->add_flag("--json", values->json, "print one JSON object");
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
  command->add_option("--at", values->at, "times, s or with a unit; default: 11 from begin to end");
  command
      ->add_option("-o,--output", values->output,
                   "file to write: NAME.vtu for one time, NAME.pvd for several, with NAME_0000.vtu and so on "
                   "beside it; of a flow NAME.xdmf, which refers to the flow file; NAME.flat")
      ->required();
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
  command->add_flag("--json", values->json, "print one JSON object");
  on_call(command, arguments.validate, values);
}

void add_fit(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<FitArguments>();
  CLI::App* command = app.add_subcommand("fit", "coefficients with uncertainty from captured trajectories");
  command
      ->add_option(
          "SOURCE", values->source,
          "codebook file, or a model by its name or its file of equations (with a config that has a [box])")
      ->required();
  // Not required for the parser, which would take the last capture left out for one to fit.
  command->add_option("CAPTURE", values->captures,
                      "capture files: tables, or sidecars (.toml) that map one; or one PEtab problem "
                      "(.yaml), config included");
  command->add_option("--sidecar", values->sidecar,
                      "what the columns of all tables given are, TOML, in place of sidecars beside them");
  command->add_option("--config", values->config, "what to fit and how, TOML");
  command->add_option(
      "--coefficients", values->coefficients,
      "JSON of another fit: its coefficients are where this one begins, or held where the "
      "config has no box for them; without a CAPTURE all are held, and --left-out is predicted");
  command->add_option("--span,--window", values->span,
                      "only this much of each capture from its first frame, s or with a unit");
  command->add_flag("--reference", values->reference,
                    "integrate (CVODES with sensitivities) instead of querying the codebook; only with one");
  command->add_flag("--profiles", values->profiles,
                    "fit again with each coefficient held at other values: intervals, and whether there is a "
                    "limit to both sides");
  command->add_option(
      "--left-out", values->left_out,
      "captures to predict, one or more: their span is seen, with the coefficients held, and --ahead is "
      "compared");
  command->add_option("--left-out-span,--left-out-window", values->left_out_span,
                      "how much of each of them is seen, s or with a unit; default: as --span");
  command->add_option("--ahead", values->ahead, "how far beyond the span to predict, s or with a unit");
  command->add_option("--petab", values->petab,
                      "of a PEtab problem: also write its tables as the fit leaves them, parameters.tsv and "
                      "simulations.tsv, into this folder");
  command->add_option("--series", values->series,
                      "write the coefficients that change in time, those of [series] in the config, to this "
                      "codebook, for samara simulate --coefficients");
  command->add_option("-o,--output", values->output, "also write the result as JSON to this file");
  command->add_option("--report", values->report, "also write a page for the browser to this file, HTML");
  command->add_flag("--json", values->json, "print one JSON object instead of the table");
  on_call(command, arguments.fit, values);
}

void add_design(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<DesignArguments>();
  CLI::App* command = app.add_subcommand(
      "design",
      "the next experiment: which releases, outputs and times would shrink the errors of a fit most");
  command
      ->add_option("SOURCE", values->source, "codebook file, or name of a model (with the config of the fit)")
      ->required();
  command->add_option("--fit", values->fit, "JSON of the fit so far (samara fit -o)")->required();
  command->add_option("--config", values->config, "of that fit, TOML; needed for a model only");
  command->add_option("--captures", values->captures, "how many more")
      ->capture_default_str()
      ->check(whole_number());
  command->add_option("--duration", values->duration,
                      "of each, s or with a unit; default: as the longest of the fit");
  command->add_option("--frames", values->frames, "of each; default: at the rate of the fit's")
      ->check(whole_number());
  command
      ->add_option(
          "--release", values->release,
          "a coordinate that can be chosen; default: all that are no coefficients; the others stay where "
          "the captures of the fit were in the mean")
      ->allow_extra_args(false);
  command
      ->add_option("--set", values->set,
                   "where a release must be, NAME=VALUE or NAME=FROM..TO, SI or with units: \"theta(0)=20 "
                   "deg..60 deg\"")
      ->allow_extra_args(false);
  command->add_option("--seen", values->outputs, "an output that is seen; default: what the fit compared")
      ->allow_extra_args(false);
  command->add_option("--noise", values->noise, "of an output, NAME=VALUE; default: what the fit found")
      ->allow_extra_args(false);
  command
      ->add_option("--criterion", values->criterion,
                   "D (the volume of what remains possible) or A (the mean square of relative errors)")
      ->capture_default_str();
  command->add_option("--for", values->coefficients, "a coefficient whose error counts; default: all")
      ->allow_extra_args(false);
  command->add_option("--times", values->times, "also find so many frames that say most alone")
      ->check(whole_number());
  command->add_option("--draws", values->draws, "of the coefficients from what the fit leaves open")
      ->capture_default_str()
      ->check(whole_number());
  command->add_option("--seed", values->seed, "of draws and first releases")
      ->capture_default_str()
      ->check(whole_number<std::uint64_t>());
  command->add_option("-o,--output", values->output, "also write the design as JSON to this file");
  command->add_flag("--json", values->json, "print one JSON object instead of the tables");
  on_call(command, arguments.design, values);
}

}  // namespace

namespace {

/// `--config "$CONFIG"` with a variable that is not set must not mean that there is no config.
void refuse_empty(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (option->get_items_expected_max() == 0 || option->get_required()) continue;
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

}  // namespace

Arguments parse(int argc, const char* const* argv) {
  Arguments arguments;
  CLI::App app(
      "Parametric solution codebooks of bodies moving in a fluid.\n"
      "Exit codes: 0 done, 1 internal failure, 2 wrong call, 3 bad input file, 4 tolerance or convergence "
      "missed,\n"
      "5 query outside the box, 130 interrupted.",
      "samara");
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  app.add_option("--model-library", arguments.model_libraries,
                 "shared library of models of your own, before the command; may be repeated")
      ->allow_extra_args(false);
  add_models(app, arguments);
  add_simulate(app, arguments);
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
  add_wind(app, arguments);
  add_flow(app, arguments);
  add_picture(app, arguments);
  add_motion_commands(app, arguments);
  add_planning_commands(app, arguments);
  for (CLI::App* command : app.get_subcommands({})) refuse_empty(*command);
  check_command(app, argc, argv);
  try {
    app.parse(argc, argv);
    for (const CLI::App* command : app.get_subcommands()) check_row(*command);
  } catch (const CLI::Success& help) {
    std::ostringstream text;
    arguments.exit_code = app.exit(help, text, text);
    print(text.str());
  } catch (const CLI::ParseError& error) {
    complain(error.what());
    arguments.exit_code = kWrongCall;
  }
  return arguments;
}

}  // namespace samara::apps
