#include "inputs/bodies.h"

#include <fmt/format.h>

#include "inputs/assignments.h"
#include "samara/base/errors.h"
#include "terminal/terminal.h"

namespace samara::apps {

models::BodyDescription description_of(const BodyWords& words) {
  const auto density = [&](const char* option, const std::string& text) {
    if (text.empty()) throw ArgumentError(fmt::format("a body needs {}, kg/m^3 or with a unit", option));
    return number_or_quantity(option, text, "kg/m^3");
  };
  models::BodyDescription description{.shape = words.body,
                                      .density = density("--density", words.density),
                                      .fluid_density = density("--fluid", words.fluid),
                                      .added_mass = words.added_mass};
  for (const std::string& text : words.sizes)
    description.sizes.push_back(number_or_quantity("--size", text, "m"));
  if (!words.unit.empty()) description.unit = number_or_quantity("--unit", "1 " + words.unit, "m");
  return description;
}

models::BodyInFluid work_out(const models::BodyDescription& description) {
  models::BodyInFluid body = models::body_in_fluid(description, progress_line());
  clear_progress();
  for (const std::string& sentence : body.warnings) warn(sentence);
  if (body.by_panels) narrate(body.panels);
  return body;
}

std::map<std::string, double> parameters_of(const models::BodyDescription& description) {
  return models::kirchhoff_parameters(work_out(description));
}

}  // namespace samara::apps
