#include "books/planned_build.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "inputs/assignments.h"
#include "inputs/bodies.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/plan/plan_changes.h"
#include "samara/io/text_file.h"
#include "samara/models/interface/model.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

std::string plan_text(const BuildArguments& arguments) {
  if (arguments.plan == "-") require_stdin("a plan of a codebook");
  return io::read_text_file(arguments.plan == "-" ? "/dev/stdin" : arguments.plan,
                            {.expected = "a plan of a codebook"});
}

codebooks::PlanChanges changes_of(const BuildArguments& arguments, const std::vector<std::string>& known) {
  codebooks::PlanChanges changes;
  for (const std::string& text : arguments.set) {
    const Setting setting = setting_of("--set", text);
    const std::string name = full_name(setting.name, known);
    if (!contains(known, name))
      throw ArgumentError(
          fmt::format("--set: unknown name \"{}\"{}", setting.name, suggestion(setting.name, known)));
    if (std::ranges::count(changes.coordinates, name, &codebooks::PlanChanges::Coordinate::name) > 0)
      throw ArgumentError(fmt::format("--set: \"{}\" is set twice", name));
    const auto [lower, upper] = ends_of(setting.text);
    changes.coordinates.push_back({name, lower, upper.value_or("")});
    if (lower.empty() || (upper && upper->empty()))
      throw ArgumentError(fmt::format("--set \"{}\": NAME=VALUE or NAME=FROM..TO was expected", text));
  }
  if (!arguments.tolerance.empty())
    changes.relative = number_or_quantity("--tolerance", arguments.tolerance, "1");
  if (!arguments.threads.empty()) {
    const double threads = number_or_quantity("--threads", arguments.threads, "1");
    if (!(threads >= 0.0 && threads <= 1024.0) || threads != std::floor(threads))
      throw ArgumentError(
          fmt::format("--threads is {}, expected a whole number from 0 to 1024", arguments.threads));
    changes.threads = static_cast<int>(threads);
  }
  return changes;
}

/// Everything that a plan may fix or free.
std::vector<std::string> names_in(const codebooks::Plan& plan) {
  std::vector<std::string> names;
  const models::ModelInfo* info = plan.definition ? &plan.definition->info()
                                  : plan.field    ? &plan.field->info
                                                  : nullptr;
  if (info != nullptr) {
    for (const models::ParameterInfo& parameter : info->parameters) names.push_back(parameter.name);
    if (plan.field == nullptr)
      for (const models::StateInfo& state : info->states) names.push_back(state.name + "(0)");
  }
  if (plan.command)
    for (const codebooks::CommandQuantity& input : plan.command->inputs) names.push_back(input.name);
  return names;
}

std::string unit_in(const codebooks::Plan& plan, const std::string& name) {
  const models::ModelInfo* info = plan.definition ? &plan.definition->info()
                                  : plan.field    ? &plan.field->info
                                                  : nullptr;
  if (info != nullptr) {
    for (const models::ParameterInfo& parameter : info->parameters)
      if (parameter.name == name) return parameter.unit;
    for (const models::StateInfo& state : info->states)
      if (state.name + "(0)" == name) return state.unit;
  }
  if (plan.command)
    for (const codebooks::CommandQuantity& input : plan.command->inputs)
      if (input.name == name) return input.unit;
  return "1";
}

}  // namespace

codebooks::Plan plan_of(const BuildArguments& arguments) {
  const std::string name = arguments.plan == "-" ? "stdin" : arguments.plan, text = plan_text(arguments);
  const codebooks::Plan plan = codebooks::parse_plan(text, name, {}, parameters_of);
  const codebooks::PlanChanges changes = changes_of(arguments, names_in(plan));
  return changes.empty() ? plan : codebooks::changed_plan(text, name, changes, parameters_of);
}

Json planned_json(const codebooks::Plan& plan) {
  Json object = {
      {"schema", "samara-plan/1"},
      {"model", plan.command ? Json(nullptr) : Json(plan.model)},
      {"command", plan.command ? Json(plan.command->run) : Json(nullptr)},
      {"title", plan.title},
      {"fixed", Json::object()},
      {"box", Json::array()},
      {"end", plan.end > 0.0 ? Json(plan.end) : Json(nullptr)},
      {"relative", plan.relative},
      {"builder",
       {{"kind", plan.builder.kind}, {"strategy", plan.builder.strategy}, {"threads", plan.builder.threads}}},
      {"certificate_points", plan.certificate_points()},
      {"text", plan.text}};
  for (const auto& [name, value] : plan.fixed) object["fixed"][name] = value;
  for (const codebooks::BoxEntry& entry : plan.box)
    object["box"].push_back({{"name", entry.name},
                             {"unit", unit_in(plan, entry.name)},
                             {"lower", entry.lower},
                             {"upper", entry.upper}});
  return object;
}

std::string planned_text(const codebooks::Plan& plan) {
  std::string text =
      plan.command ? fmt::format("command: {}\n", fmt::join(plan.command->run, " "))
                   : fmt::format("model {}{}\n", plan.model, plan.title.empty() ? "" : ": " + plan.title);
  for (const auto& [name, value] : plan.fixed)
    text += fmt::format("  {} = {:.6g}{}\n", name, value, unit_suffix(unit_in(plan, name)));
  for (const codebooks::BoxEntry& entry : plan.box)
    text += fmt::format("  {} from {:.6g} to {:.6g}{}\n", entry.name, entry.lower, entry.upper,
                        unit_suffix(unit_in(plan, entry.name)));
  if (plan.end > 0.0) {
    const std::string unit = plan.definition ? models::time_unit(plan.definition->info()) : "s";
    text += fmt::format("  t from 0 to {:.6g}{}\n", plan.end, unit_suffix(unit));
  }
  text +=
      fmt::format("to {:.3g} of the range of each output, by the builder \"{}\"; certificate at {} points\n",
                  plan.relative, plan.builder.kind, plan.certificate_points());
  return printable(text, "\n") + "the plan is sound; nothing was built\n";
}

}  // namespace samara::apps
