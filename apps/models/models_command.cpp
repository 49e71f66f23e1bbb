#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/models/checks/check_model.h"
#include "samara/models/fields/field_model.h"
#include "samara/models/interface/model.h"
#include "samara/models/laws/registry.h"
#include "terminal/output.h"
#include "terminal/terminal.h"
#include "terminal/text_layout.h"

namespace samara::apps {

namespace {

struct ModelsArguments {
  std::string model;  ///< empty: all
  std::string output;
  bool json = false;
  bool check = false;  ///< what check_model() says of it
};

std::string default_text(const models::ParameterInfo& parameter) {
  if (parameter.default_value) return fmt::format("{}", *parameter.default_value);
  return parameter.derived.empty() ? "required" : parameter.derived;
}

const char* kind_text(models::StateGroupKind kind) {
  switch (kind) {
    case models::StateGroupKind::position:
      return "position";
    case models::StateGroupKind::vector:
      return "vector";
    case models::StateGroupKind::quaternion:
      return "quaternion";
  }
  return "";
}

/// A model of trajectories, or of a field.
struct Listed {
  std::shared_ptr<const models::Model> model;  ///< null of a field
  const models::FieldModel* field = nullptr;   ///< null of others
  const models::ModelInfo& info() const { return model ? model->info() : field->info; }
};

Json listed_json(const Listed& listed) {
  const models::ModelInfo& info = listed.info();
  const models::ForceUnits units = models::force_units(info);
  Json object = {{"name", info.name},
                 {"title", info.title},
                 {"kind", listed.model ? "trajectories" : "field"},
                 {"equations", info.equations},
                 {"frames", info.frames},
                 {"source", info.source},
                 {"validity", info.validity},
                 {"symmetries", info.symmetries},
                 {"time_unit", models::time_unit(info)},
                 {"states", Json::array()},
                 {"groups", Json::array()},
                 {"parameters", Json::array()},
                 {"outputs", Json::array()},
                 {"affine_in", info.affine_in},
                 {"force_terms", Json::array()},
                 {"force_units", {{"force", units.force}, {"torque", units.torque}, {"power", units.power}}}};
  for (const auto& s : info.states) {
    object["states"].push_back({{"name", s.name},
                                {"unit", s.unit},
                                {"default_initial", s.default_initial},
                                {"description", s.description}});
  }
  for (const auto& output : info.outputs) {
    object["outputs"].push_back(
        {{"name", output.name}, {"unit", output.unit}, {"description", output.description}});
  }
  for (const auto& g : info.groups) {
    object["groups"].push_back({{"kind", kind_text(g.kind)}, {"first", g.first}});
  }
  for (const auto& p : info.parameters) {
    Json parameter = {{"name", p.name}, {"unit", p.unit}, {"description", p.description}};
    parameter["default"] = p.default_value ? Json(*p.default_value) : Json(nullptr);
    parameter["derived"] = p.derived.empty() ? Json(nullptr) : Json(p.derived);
    parameter["lower"] = std::isfinite(p.lower) ? Json(p.lower) : Json(nullptr);
    parameter["lower_inclusive"] = p.lower_inclusive;
    parameter["upper"] = std::isfinite(p.upper) ? Json(p.upper) : Json(nullptr);
    object["parameters"].push_back(parameter);
  }
  for (const auto& term : info.force_terms) {
    object["force_terms"].push_back({{"name", term.name}, {"description", term.description}});
  }
  return object;
}

/// Equations stand apart by a comma or a semicolon and two spaces.
std::string equation_lines(const std::string& equations) {
  std::string lines;
  for (std::size_t begin = 0; begin < equations.size();) {
    const std::size_t end =
        std::min({equations.find(",  ", begin), equations.find(";  ", begin), equations.size()});
    lines += fmt::format("  {}\n", wrapped(equations.substr(begin, end - begin), 6, screen_width(), 2));
    begin = end + 3;
  }
  return lines;
}

std::string counted(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

using Row = std::vector<std::string>;

/// Rows as wide as their widest cell; the last column is wrapped.
std::string table(const std::vector<Row>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const Row& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
  }
  std::string text;
  for (const Row& row : rows) {
    std::string line(2, ' ');
    for (std::size_t k = 0; k + 1 < row.size(); ++k) line += fmt::format("{:<{}}  ", row[k], widths[k]);
    text += fmt::format("{}{}\n", line, wrapped(row.back(), line.size(), screen_width(), line.size()));
  }
  return text;
}

/// A long formula of a default goes where lines are wrapped.
Row parameter_row(const models::ParameterInfo& parameter) {
  constexpr std::size_t kShort = 24;
  const std::string value = default_text(parameter);
  if (value.size() <= kShort)
    return {parameter.name, shown_unit(parameter.unit), value, parameter.description};
  const bool says_what = parameter.description.find("default:") != std::string::npos;
  return {parameter.name, shown_unit(parameter.unit), "derived",
          parameter.description + (says_what ? ": " : "; default: ") + value};
}

std::string joined(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

/// What a field gives, and over what.
std::string field_table(const models::FieldModel& field) {
  std::vector<Row> rows = {{"coordinate", "unit", "meaning"},
                           {"t", shown_unit(models::time_unit(field.info)), "time, from 0"},
                           {field.place, "m", fmt::format("place, from 0 to {}", field.extent)}};
  std::vector<Row> outputs = {{"output", "unit", "meaning"}};
  for (const auto& s : field.info.states) outputs.push_back({s.name, shown_unit(s.unit), s.description});
  return fmt::format("{}\n{}", table(rows), table(outputs));
}

std::string explain(const Listed& listed) {
  const models::ModelInfo& info = listed.info();
  std::string text = fmt::format("{}: {}\n\n{}\n", info.name, info.title, equation_lines(info.equations));
  std::vector<Row> facts = {{"frames:", info.frames}, {"source:", info.source}, {"valid:", info.validity}};
  if (!info.symmetries.empty()) facts.push_back({"symmetries:", joined(info.symmetries)});
  if (!info.affine_in.empty()) facts.push_back({"affine in:", joined(info.affine_in)});
  text += table(facts);

  std::vector<Row> parameters = {{"parameter", "unit", "default", "meaning"}};
  for (const auto& p : info.parameters) {
    parameters.push_back(parameter_row(p));
  }
  if (listed.field != nullptr)
    return fmt::format("{}\n{}\n{}", text, table(parameters), field_table(*listed.field));
  std::vector<Row> states = {{"initial value", "unit", "default", "state"}};
  for (const auto& s : info.states) {
    states.push_back(
        {s.name + "(0)", shown_unit(s.unit), fmt::format("{}", s.default_initial), s.description});
  }
  text += fmt::format("\n{}\n{}", table(parameters), table(states));
  if (!info.outputs.empty()) {
    std::vector<Row> outputs = {{"output", "unit", "meaning"}};
    for (const auto& output : info.outputs)
      outputs.push_back({output.name, shown_unit(output.unit), output.description});
    text += fmt::format("\n{}", table(outputs));
  }
  if (info.force_terms.empty()) return text;
  std::vector<Row> terms = {{"force term", "meaning"}};
  for (const auto& term : info.force_terms) terms.push_back({term.name, term.description});
  return fmt::format("{}\n{}", text, table(terms));
}

/// Adds what the check says. @returns whether all promises hold
bool append_check(const models::Model& model, std::string& text) {
  const Check check = models::check_model(model);
  text += fmt::format("{}: {}, {}\n", model.info().name, counted(check.findings.size(), "finding"),
                      counted(check.notes.size(), "kink"));
  for (const std::vector<std::string>* sentences : {&check.findings, &check.notes}) {
    for (const std::string& sentence : *sentences)
      text += fmt::format("  {}\n", wrapped(sentence, 4, screen_width(), 2));
  }
  return check.passed();
}

int run_models(const ModelsArguments& arguments) {
  if (!arguments.output.empty())
    check_text_output(arguments.output, {arguments.model}, arguments.json ? ".json" : ".txt");
  std::vector<Listed> listed;
  const models::FieldModel* field = models::find_field_model(arguments.model);
  if (field != nullptr) {
    listed.push_back({nullptr, field});
  } else if (!arguments.model.empty()) {
    listed.push_back({codebooks::open_model(arguments.model)});
  } else {
    for (const std::string& name : models::model_names()) listed.push_back({models::find_model(name)});
    for (const std::string& name : models::field_model_names())
      listed.push_back({nullptr, models::find_field_model(name)});
  }
  std::ranges::sort(listed, {}, [](const Listed& one) { return one.info().name; });
  if (arguments.check) {
    if (field != nullptr) {
      throw ArgumentError(
          fmt::format("--check is of models of trajectories, and \"{}\" is a field", arguments.model));
    }
    bool passed = true;
    std::string text;
    for (const Listed& one : listed) passed = (!one.model || append_check(*one.model, text)) && passed;
    write_answer(arguments.output, text);
    return passed ? kDone : kToleranceMissed;
  }
  if (arguments.json) {
    Json object = {{"schema", "samara-models/1"}, {"models", Json::array()}};
    for (const Listed& one : listed) object["models"].push_back(listed_json(one));
    write_answer(arguments.output, json_line(object));
  } else if (!arguments.model.empty()) {
    write_answer(arguments.output, explain(listed.front()));
  } else {
    std::size_t longest = 0;
    for (const Listed& one : listed) longest = std::max(longest, one.info().name.size());
    std::string text;
    for (const Listed& one : listed)
      text += fmt::format("{:<{}}  {}\n", one.info().name, longest, one.info().title);
    write_answer(arguments.output, text);
  }
  return kDone;
}

}  // namespace

void add_models(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<ModelsArguments>();
  CLI::App* command =
      app.add_subcommand("models", "models with parameters, units, defaults, sources, validity");
  command->add_option("NAME", values->model,
                      "explain this model only, or the equations of a file (MODEL.toml)");
  CLI::Option* json = command->add_flag("--json", values->json, kJson);
  command->add_flag("--check", values->check, "check its promises, and name the kinks of its law")
      ->excludes(json);
  command->add_option("-o,--output", values->output, kAnswerFile);
  on_call(*command, arguments, values, run_models);
}

}  // namespace samara::apps
