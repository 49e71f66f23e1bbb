#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "inputs/assignments.h"
#include "options/commands.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/design/design_report.h"
#include "samara/identification/files/design_files.h"
#include "samara/io/atomic_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

std::map<std::string, models::Interval> boxes_of(const DesignArguments& arguments,
                                                 const models::FamilyInfo& family) {
  std::map<std::string, models::Interval> boxes;
  for (const std::string& given : arguments.set) {
    const auto [name, text] = setting_of("--set", given);
    const auto at = models::position(family.coordinates, name);
    if (!at) {
      throw ArgumentError(fmt::format("--set: unknown name \"{}\"{}", name,
                                      suggestion(name, models::names_of(family.coordinates))));
    }
    if (!boxes.emplace(name, interval_of(name, text, family.coordinates[*at].unit)).second)
      throw ArgumentError(fmt::format("--set: \"{}\" is set twice", name));
  }
  return boxes;
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
    if (!noise.emplace(name, number_or_quantity(name, text, unit->second)).second)
      throw ArgumentError(fmt::format("--noise: \"{}\" is given twice", name));
  }
  return noise;
}

id::DesignOptions options_of(const DesignArguments& arguments, const models::FamilyInfo& family) {
  id::DesignOptions options{.captures = arguments.captures,
                            .frames = arguments.frames,
                            .release = arguments.release,
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

}  // namespace

int run(const DesignArguments& arguments) {
  if (!arguments.output.empty())
    check_output(arguments.output, {arguments.source, arguments.fit, arguments.config});
  const id::Design design = id::design_files(
      {.source = arguments.source,
       .fit = arguments.fit,
       .config = arguments.config,
       .options = [&](const models::FamilyInfo& family) { return options_of(arguments, family); },
       .warning = [](const std::string& sentence) { warn(sentence); }});
  clear_progress();
  if (!arguments.output.empty()) io::write_text_atomically(arguments.output, id::design_json(design));
  print(arguments.json ? id::design_json(design) : printable(id::design_text(design), "\n"));
  return kDone;
}

}  // namespace samara::apps
