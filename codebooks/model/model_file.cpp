#include "samara/codebooks/model/model_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/io/text_file.h"
#include "samara/models/fields/field_model.h"
#include "samara/models/laws/registry.h"

namespace samara::codebooks {

namespace {

using io::TomlTable;

std::string text_of(const TomlTable& table, const std::string& key) {
  return table.optional_string(key).value_or("");
}

std::string unit_of(const TomlTable& table) {
  return table.optional_string("unit").value_or("1");
}

std::vector<models::StateInfo> read_states(const TomlTable& table) {
  std::vector<models::StateInfo> states;
  for (const std::string& name : table.keys()) {
    const TomlTable state = table.table(name);
    state.expect_keys({"unit", "initial", "scale", "description"});
    models::StateInfo info{
        .name = name, .unit = unit_of(state), .description = text_of(state, "description")};
    info.default_initial = state.optional_quantity("initial", info.unit).value_or(0.0);
    info.scale = state.optional_quantity("scale", info.unit);
    if (!info.scale && info.default_initial != 0.0) info.scale = std::abs(info.default_initial);
    states.push_back(std::move(info));
  }
  return states;
}

/// "expression", or a table with its unit.
std::vector<std::pair<models::OutputInfo, std::string>> read_outputs(const TomlTable& table) {
  std::vector<std::pair<models::OutputInfo, std::string>> outputs;
  for (const std::string& name : table.keys()) {
    models::OutputInfo info{.name = name, .unit = "1"};
    if (table.is_string(name)) {
      outputs.emplace_back(std::move(info), table.string(name));
      continue;
    }
    const TomlTable output = table.table(name);
    output.expect_keys({"value", "unit", "description"});
    info.unit = unit_of(output);
    info.description = text_of(output, "description");
    outputs.emplace_back(std::move(info), output.string("value"));
  }
  return outputs;
}

std::vector<models::ParameterInfo> read_parameters(const TomlTable& table) {
  std::vector<models::ParameterInfo> parameters;
  for (const std::string& name : table.keys()) {
    const TomlTable parameter = table.table(name);
    parameter.expect_keys({"unit", "default", "above", "at_least", "at_most", "description"});
    models::ParameterInfo info{
        .name = name, .unit = unit_of(parameter), .description = text_of(parameter, "description")};
    info.default_value = parameter.optional_quantity("default", info.unit);
    if (parameter.has("above") && parameter.has("at_least"))
      throw parameter.error("at_least", "stands beside \"above\", expected one of the two");
    if (const auto above = parameter.optional_quantity("above", info.unit)) info.lower = *above;
    if (const auto at_least = parameter.optional_quantity("at_least", info.unit)) {
      info.lower = *at_least;
      info.lower_inclusive = true;
    }
    if (const auto at_most = parameter.optional_quantity("at_most", info.unit)) info.upper = *at_most;
    if (info.lower > info.upper)
      throw parameter.error("at_most",
                            fmt::format("is {}, below the least value {}", info.upper, info.lower));
    parameters.push_back(std::move(info));
  }
  return parameters;
}

}  // namespace

std::string quoted_toml(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      result += fmt::format("\\u{:04X}", static_cast<unsigned char>(c));
    } else {
      result += c;
    }
  }
  return result + "\"";
}

namespace {

void add_text(std::string& toml, const char* key, const std::string& text) {
  if (!text.empty()) toml += fmt::format("{} = {}\n", key, quoted_toml(text));
}

void add_number(std::string& toml, const char* key, std::optional<double> value) {
  if (value && std::isfinite(*value)) toml += fmt::format("{} = {}\n", key, *value);
}

std::string key_of(models::EquationPart part) {
  using enum models::EquationPart;
  switch (part) {
    case states:
      return "states";
    case parameters:
      return "parameters";
    case abbreviations:
      return "let";
    case rates:
      return "rates";
    case outputs:
      return "outputs";
  }
  return {};
}

}  // namespace

models::Equations read_equations(const TomlTable& table) {
  table.expect_keys(
      {"name", "title", "frames", "source", "validity", "states", "parameters", "let", "rates", "outputs"});
  models::Equations equations;
  if (const auto name = table.optional_string("name")) equations.name = *name;
  equations.title = text_of(table, "title");
  equations.frames = text_of(table, "frames");
  equations.source = text_of(table, "source");
  equations.validity = text_of(table, "validity");
  equations.states = read_states(table.table("states"));
  if (const auto parameters = table.optional_table("parameters"))
    equations.parameters = read_parameters(*parameters);
  if (const auto let = table.optional_table("let")) {
    for (const std::string& name : let->keys()) equations.abbreviations.emplace_back(name, let->string(name));
  }
  if (const auto outputs = table.optional_table("outputs")) equations.outputs = read_outputs(*outputs);
  const TomlTable rates = table.table("rates");
  std::vector<std::string> known;
  for (const models::StateInfo& state : equations.states) known.push_back(state.name);
  rates.expect_keys(known);
  for (const std::string& name : known) equations.rates.push_back(rates.string(name));
  return equations;
}

std::shared_ptr<const models::Model> read_equation_model(const TomlTable& table) {
  const models::Equations equations = read_equations(table);
  try {
    return models::equation_model(equations);
  } catch (const models::EquationError& error) {
    const std::string key = key_of(error.part());
    if (!error.name().empty()) throw table.table(key).error(error.name(), error.what());
    throw table.error(key, error.what());
  }
}

std::string to_toml(const models::Equations& equations) {
  std::string toml;
  add_text(toml, "name", equations.name);
  add_text(toml, "title", equations.title);
  add_text(toml, "frames", equations.frames);
  add_text(toml, "source", equations.source);
  add_text(toml, "validity", equations.validity);
  for (const models::StateInfo& state : equations.states) {
    toml += fmt::format("[states.{}]\n", state.name);
    add_text(toml, "unit", state.unit);
    add_number(toml, "initial", state.default_initial);
    add_number(toml, "scale", state.scale);
    add_text(toml, "description", state.description);
  }
  for (const models::ParameterInfo& parameter : equations.parameters) {
    toml += fmt::format("[parameters.{}]\n", parameter.name);
    add_text(toml, "unit", parameter.unit);
    add_number(toml, "default", parameter.default_value);
    add_number(toml, parameter.lower_inclusive ? "at_least" : "above", parameter.lower);
    add_number(toml, "at_most", parameter.upper);
    add_text(toml, "description", parameter.description);
  }
  if (!equations.abbreviations.empty()) toml += "[let]\n";
  for (const auto& [name, text] : equations.abbreviations) add_text(toml, name.c_str(), text);
  toml += "[rates]\n";
  for (std::size_t i = 0; i < equations.states.size(); ++i)
    add_text(toml, equations.states[i].name.c_str(), equations.rates[i]);
  for (const auto& [output, text] : equations.outputs) {
    toml += fmt::format("[outputs.{}]\n", output.name);
    add_text(toml, "value", text);
    add_text(toml, "unit", output.unit);
    add_text(toml, "description", output.description);
  }
  return toml;
}

void check_name(const TomlTable& table) {
  const auto name = table.optional_string("name");
  if (name && (models::find_model_or_null(*name) || models::find_field_model(*name) != nullptr))
    throw table.error("name",
                      fmt::format("is \"{}\", which is another model, expected a name of its own", *name));
}

bool is_model_file(const std::string& name_or_file) {
  return ending_of(name_or_file) == ".toml";
}

std::shared_ptr<const models::Model> open_model(const std::string& name_or_file,
                                                const std::filesystem::path& folder) {
  if (!is_model_file(name_or_file)) {
    std::error_code ignored;
    if (!models::find_model_or_null(name_or_file) && std::filesystem::exists(folder / name_or_file, ignored))
      throw ArgumentError(fmt::format("\"{}\" is no model; a file of equations ends in .toml", name_or_file));
    if (models::find_field_model(name_or_file) != nullptr) {
      throw ArgumentError(fmt::format(
          "\"{}\" is a field of space, which has no trajectory of a few states: samara build makes its "
          "codebook, and samara query asks it",
          name_or_file));
    }
    return models::find_model(name_or_file);
  }
  const TomlTable file = TomlTable::read(folder / name_or_file, "a model");
  // A plan may hold the equations itself.
  const TomlTable table = file.optional_table("equations").value_or(file);
  if (table.has("columns") || table.has("group_by"))
    throw table.error(table.has("columns") ? "columns" : "group_by",
                      "is that of a sidecar, expected a model or a codebook here");
  if (table.has("box"))
    throw table.error(
        "box",
        "is that of a plan, and the plan holds no [equations]; expected a model, or the codebook that "
        "samara build makes of the plan");
  check_name(table);
  return read_equation_model(table);
}

}  // namespace samara::codebooks
