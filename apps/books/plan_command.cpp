#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "books/planned_build.h"
#include "inputs/assignments.h"
#include "inputs/bodies.h"
#include "options/commands.h"
#include "options/option_parts.h"
#include "samara/base/text.h"
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

struct PlanArguments {
  std::string model;
  std::string output;
  bool json = false;
};

std::vector<std::string> settable_names(const models::ModelInfo& info) {
  std::vector<std::string> names;
  for (const models::ParameterInfo& parameter : info.parameters) names.push_back(parameter.name);
  for (const models::StateInfo& state : info.states) names.push_back(state.name + "(0)");
  return names;
}

/// A file of TOML with a box is a plan, another one a model.
bool is_plan(const std::string& source) {
  return ending_of(source) == ".toml" && io::read_text_file(source).find("[box]") != std::string::npos;
}

std::vector<std::string> names_of(const std::string& source) {
  if (const models::FieldModel* field = models::find_field_model(source)) return settable_names(field->info);
  std::error_code ignored;
  if (std::filesystem::is_regular_file(source, ignored) && codebooks::is_codebook(source)) {
    std::vector<std::string> names;
    const codebooks::Codebook book = codebooks::load(source);
    for (const codebooks::Coordinate& c : book.parameters()) names.push_back(c.name);
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

/// A plan names the file of its model as seen from its own folder.
std::string name_in_plan(const std::string& model, const std::string& output) {
  namespace fs = std::filesystem;
  if (output.empty() || !codebooks::is_model_file(model) || fs::path(model).is_absolute()) return model;
  const auto folder = [](const std::string& file) {
    return fs::weakly_canonical(fs::absolute(file).parent_path());
  };
  return (folder(model) / fs::path(model).filename()).lexically_relative(folder(output)).generic_string();
}

int run_plan(const PlanArguments& arguments) {
  if (!arguments.output.empty()) {
    check_text_output(arguments.output, {arguments.model}, ".toml");
    check_replaced(arguments.output, "plan", "[box");
  }
  std::string text;
  if (const models::FieldModel* field = models::find_field_model(arguments.model)) {
    text = codebooks::plan_template(*field);
  } else {
    const auto model = codebooks::open_model(arguments.model);
    text = codebooks::plan_template(*model, name_in_plan(arguments.model, arguments.output));
  }
  if (!arguments.output.empty() || !arguments.json) write_answer(arguments.output, text);
  if (arguments.json)
    print(
        planned_json(codebooks::parse_plan(text, arguments.output.empty() ? "the plan" : arguments.output)));
  return kDone;
}

}  // namespace

void add_plan(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<PlanArguments>();
  CLI::App* command = app.add_subcommand(
      "plan", "a plan to begin with, with comments, for a model: samara build takes it as it is");
  command
      ->add_option("MODEL", values->model,
                   "name of a model (samara models), or file with equations (MODEL.toml)")
      ->required();
  command->add_option("-o,--output", values->output, "file for the plan, TOML; stdout if not given");
  command->add_flag("--json", values->json, "print one JSON object: what the plan asks for, and its text");
  on_call(*command, arguments, values, run_plan);
}

int print_names(const std::string& source) {
  const std::vector<std::string> names = names_of(source);
  std::string text;
  for (const std::string& name : names) text += shell_name(name, names) + "\n";
  print(text);
  return kDone;
}

}  // namespace samara::apps
