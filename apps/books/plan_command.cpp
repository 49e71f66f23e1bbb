#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "inputs/assignments.h"
#include "inputs/bodies.h"
#include "options/commands.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/codebooks/plan/plan_template.h"
#include "samara/io/text_file.h"
#include "samara/models/fields/field_model.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

std::vector<std::string> settable_names(const models::ModelInfo& info) {
  std::vector<std::string> names;
  for (const models::ParameterInfo& parameter : info.parameters) names.push_back(parameter.name);
  for (const models::StateInfo& state : info.states) names.push_back(state.name + "(0)");
  return names;
}

/// A file of TOML with a box is a plan, another one a model.
bool is_plan(const std::string& source) {
  return source.ends_with(".toml") && io::read_text_file(source).find("[box]") != std::string::npos;
}

std::vector<std::string> names_of(const std::string& source) {
  if (const models::FieldModel* field = models::find_field_model(source)) return settable_names(field->info);
  std::error_code ignored;
  if (std::filesystem::is_regular_file(source, ignored) && codebooks::is_codebook(source)) {
    std::vector<std::string> names;
    for (const codebooks::Coordinate& c : codebooks::load(source).parameters()) names.push_back(c.name);
    return names;
  }
  if (!is_plan(source)) return settable_names(codebooks::open_model(source)->info());
  const codebooks::Plan plan = codebooks::read_plan(source, parameters_of);
  if (plan.definition) return settable_names(plan.definition->info());
  std::vector<std::string> names;
  for (const codebooks::BoxEntry& entry : plan.box) names.push_back(entry.name);
  for (const auto& [name, value] : plan.fixed) names.push_back(name);
  return names;
}

}  // namespace

int run(const PlanArguments& arguments) {
  if (!arguments.output.empty()) {
    check_output(arguments.output, {arguments.model});
    check_replaced(arguments.output, "plan", "[box");
  }
  const models::FieldModel* field = models::find_field_model(arguments.model);
  write_answer(arguments.output,
               field != nullptr
                   ? codebooks::plan_template(*field)
                   : codebooks::plan_template(*codebooks::open_model(arguments.model), arguments.model));
  return kDone;
}

int run(const NamesArguments& arguments) {
  const std::vector<std::string> names = names_of(arguments.source);
  std::string text;
  for (const std::string& name : names) text += shell_name(name, names) + "\n";
  print(text);
  return kDone;
}

}  // namespace samara::apps
