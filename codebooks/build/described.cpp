#include "samara/codebooks/build/described.h"

#include <map>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/models/equations/equation_model.h"

namespace samara::codebooks {

ModelDescription describe(const models::ParametricModel& model) {
  const models::ModelInfo& info = model.model().info();
  const bool is_text = models::equations_of(model.model()) != nullptr;
  ModelDescription description{.name = info.name,
                               .title = info.title,
                               .equations = info.equations,
                               .frames = info.frames,
                               .source = info.source,
                               .fixed = model.fixed(),
                               .fixed_units = {},
                               .of_text = is_text ? model.shared_model() : nullptr};
  std::map<std::string, std::string>& units = description.fixed_units;
  for (const auto& parameter : info.parameters) units[parameter.name] = parameter.unit;
  for (const auto& state : info.states) units[state.name + "(0)"] = state.unit;
  std::erase_if(units, [&](const auto& item) { return !model.fixed().contains(item.first); });
  return description;
}

ModelDescription describe(const Plan& plan) {
  ModelDescription description;
  description.name = kCommandModel;
  description.title = "what a program answers";
  description.equations = fmt::format("{}", fmt::join(plan.command->run, " "));
  description.frames = "those of the program";
  description.source = "the plan";
  description.fixed = plan.fixed;
  for (const CommandQuantity& input : plan.command->inputs) {
    if (plan.fixed.contains(input.name)) description.fixed_units[input.name] = input.unit;
  }
  return description;
}

}  // namespace samara::codebooks
