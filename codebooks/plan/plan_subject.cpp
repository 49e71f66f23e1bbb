#include "samara/codebooks/plan/plan_subject.h"

#include <filesystem>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/models/equations/equation_model.h"

namespace samara::codebooks {

using io::TomlTable;

namespace {

PlanSubject subject_of(const models::FieldModel& field) {
  PlanSubject subject{fmt::format("the field \"{}\"", field.info.name),
                      nullptr,
                      "parameter",
                      "output",
                      {},
                      {},
                      models::time_unit(field.info),
                      &field};
  for (const auto& parameter : field.info.parameters) subject.settable[parameter.name] = parameter.unit;
  for (const auto& state : field.info.states) subject.outputs[state.name] = state.unit;
  return subject;
}

/// The one that the plan names, or brings along.
std::shared_ptr<const models::Model> read_model(const TomlTable& root) {
  if (const auto equations = root.optional_table("equations")) {
    if (root.has("model")) throw root.error("equations", "stand beside a model, expected one of the two");
    check_name(*equations);
    return read_equation_model(*equations);
  }
  const std::string name = root.string("model");
  try {
    return open_model(name, std::filesystem::path(root.file()).parent_path());
  } catch (const ArgumentError& error) {
    throw root.error("model", error.what());
  }
}

}  // namespace

/// Parameters, and initial values "s(0)".
PlanSubject subject_of(std::shared_ptr<const models::Model> model) {
  const models::ModelInfo& info = model->info();
  PlanSubject subject{fmt::format("the model \"{}\"", info.name),
                      model,
                      "parameter or initial value",
                      "state",
                      {},
                      {},
                      models::time_unit(info)};
  for (const auto& parameter : info.parameters) subject.settable[parameter.name] = parameter.unit;
  for (const auto& state : info.states) {
    subject.settable[state.name + "(0)"] = state.unit;
    subject.outputs[state.name] = state.unit;
  }
  return subject;
}

PlanSubject subject_of(const PlannedCommand& command) {
  PlanSubject subject{"the command", nullptr, "input", "output", {}, {}};
  for (const CommandQuantity& input : command.inputs) subject.settable[input.name] = input.unit;
  for (const CommandQuantity& output : command.outputs) subject.outputs[output.name] = output.unit;
  return subject;
}

const std::string& unit_of(const TomlTable& table, const std::string& key,
                           const std::map<std::string, std::string>& units, const PlanSubject& subject,
                           const std::string& what) {
  const auto it = units.find(key);
  if (it != units.end()) return it->second;
  std::vector<std::string> known;
  for (const auto& [name, unit] : units) known.push_back(name);
  throw table.error(key,
                    fmt::format("{} has no {} of this name{}", subject.name, what, suggestion(key, known)));
}

void check_meaning(const TomlTable& table, const std::string& key, const PlanSubject& subject, double value) {
  if (subject.info() == nullptr) return;
  for (const models::ParameterInfo& parameter : subject.info()->parameters) {
    if (parameter.name != key || models::in_meaning(parameter, value)) continue;
    if (value > parameter.upper) {
      throw table.error(key, fmt::format("is {}, expected at most {}", value, parameter.upper));
    }
    throw table.error(
        key, fmt::format("is {}, expected {} {}", value, parameter.lower_inclusive ? "at least" : "more than",
                         parameter.lower));
  }
}

PlanSubject read_subject(const TomlTable& root) {
  if (root.has("model") && !root.has("equations")) {
    if (const models::FieldModel* field = models::find_field_model(root.string("model")))
      return subject_of(*field);
  }
  return subject_of(read_model(root));
}

}  // namespace samara::codebooks
