#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/assignments.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/design/design_report.h"
#include "samara/identification/files/design_files.h"
#include "samara/io/atomic_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"
#include "terminal/text_layout.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

struct DesignArguments {
  std::string source;  ///< codebook file or model name
  std::string fit;     ///< JSON
  std::string config;
  int captures = 1;
  std::string duration;       ///< empty: as the fit
  std::optional<int> frames;  ///< none: as the fit
  std::vector<std::string> release;
  std::vector<std::string> set;
  std::vector<std::string> outputs;
  std::vector<std::string> noise;
  std::string criterion = "D";
  std::vector<std::string> coefficients;
  int times = 0;
  int draws = 8;
  std::uint64_t seed = 1;
  std::string output;
  bool json = false;
};

std::map<std::string, models::Interval> boxes_of(const DesignArguments& arguments,
                                                 const models::FamilyInfo& family) {
  const std::vector<std::string> known = models::names_of(family.coordinates);
  std::map<std::string, models::Interval> boxes;
  for (const std::string& given : arguments.set) {
    const auto [written, text] = setting_of("--set", given);
    const std::string name = full_name(written, known);
    const auto at = models::position(family.coordinates, name);
    if (!at) throw ArgumentError(fmt::format("--set: unknown name \"{}\"{}", name, suggestion(name, known)));
    if (!boxes.emplace(name, interval_of(name, text, family.coordinates[*at].unit)).second)
      throw ArgumentError(fmt::format("--set: \"{}\" is set twice", name));
  }
  return boxes;
}

std::vector<std::string> full_names(std::vector<std::string> names, const models::FamilyInfo& family) {
  const std::vector<std::string> known = models::names_of(family.coordinates);
  for (std::string& name : names) name = full_name(name, known);
  return names;
}

std::map<std::string, double> noise_of(const DesignArguments& arguments, const models::FamilyInfo& family) {
  std::map<std::string, std::string> units = {{"attitude", "rad"}};
  std::vector<std::string> known;
  for (const models::FamilyOutput& output : family.outputs) {
    units[output.name] = output.unit;
    known.push_back(output.name);
  }
  std::map<std::string, double> noise;
  for (const std::string& given : arguments.noise) {
    const auto [name, text] = setting_of("--noise", given);
    const auto unit = units.find(name);
    if (unit == units.end())
      throw ArgumentError(fmt::format("--noise: unknown name \"{}\"{}", name, suggestion(name, known)));
    if (!noise.emplace(name, number_or_difference(name, text, unit->second)).second)
      throw ArgumentError(fmt::format("--noise: \"{}\" is given twice", name));
  }
  return noise;
}

id::DesignOptions options_of(const DesignArguments& arguments, const models::FamilyInfo& family) {
  id::DesignOptions options{.captures = arguments.captures,
                            .frames = arguments.frames,
                            .release = full_names(arguments.release, family),
                            .box = boxes_of(arguments, family),
                            .outputs = arguments.outputs,
                            .noise = noise_of(arguments, family),
                            .criterion = id::design_criterion_from_string(arguments.criterion),
                            .coefficients = arguments.coefficients,
                            .times = arguments.times,
                            .draws = arguments.draws,
                            .seed = arguments.seed,
                            .progress = progress_line()};
  if (!arguments.duration.empty())
    options.duration = number_or_quantity("--duration", arguments.duration, "s");
  return options;
}

int run_design(const DesignArguments& arguments) {
  if (!arguments.output.empty())
    check_text_output(arguments.output, {arguments.source, arguments.fit, arguments.config}, ".json");
  const id::Design design = id::design_files(
      {.source = arguments.source,
       .fit = arguments.fit,
       .config = arguments.config,
       .options = [&](const models::FamilyInfo& family) { return options_of(arguments, family); },
       .warning = [](const std::string& sentence) { warn(sentence); }});
  clear_progress();
  if (!arguments.output.empty()) io::write_text_atomically(arguments.output, id::design_json(design));
  print(arguments.json ? id::design_json(design) : wrapped_prose(printable(id::design_text(design), "\n")));
  return kDone;
}

}  // namespace

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
  on_call(*command, arguments, values, run_design);
}

}  // namespace samara::apps
