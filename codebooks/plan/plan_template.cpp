#include "samara/codebooks/plan/plan_template.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "samara/base/names.h"
#include "samara/base/number_text.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/io/toml_edit.h"

namespace samara::codebooks {

namespace {

struct Sample {
  std::string_view name;
  double value;
};

/// By the name of a parameter: a card of paper in air, or what its unit says.
constexpr std::array<Sample, 22> kByName = {{{"density", 1200.0},
                                             {"thickness", 2e-3},
                                             {"area", 5e-4},
                                             {"semi_chord", 1e-2},
                                             {"semi_thickness", 5e-4},
                                             {"a", 3.5e-2},
                                             {"b", 2e-2},
                                             {"c", 1e-4},
                                             {"mass", 1e-2},
                                             {"C_D", 1.1},
                                             {"C_T", 1.2},
                                             {"C_R", 3.0},
                                             {"A", 1.4},
                                             {"B", 1.0},
                                             {"mu1", 0.2},
                                             {"mu2", 0.2},
                                             {"inertia_ratio", 1.1},
                                             {"beta", 0.07},
                                             {"chord", 2e-2},
                                             {"width", 2e-2},
                                             {"height", 1e-3},
                                             {"length", 0.1}}};
constexpr std::array<Sample, 8> kByUnit = {{{"kg", 1e-2},
                                            {"m", 1e-2},
                                            {"m^2", 1e-3},
                                            {"kg m^2", 1e-5},
                                            {"kg/m^3", 1000.0},
                                            {"K", 300.0},
                                            {"W/(m K)", 40.0},
                                            {"m/s", 1.0}}};

double sample_of(const models::ParameterInfo& parameter) {
  if (parameter.default_value) return *parameter.default_value;
  double value = 1.0;
  const auto* by_name = std::ranges::find(kByName, parameter.name, &Sample::name);
  const auto* by_unit = std::ranges::find(kByUnit, parameter.unit, &Sample::name);
  if (by_unit != kByUnit.end()) value = by_unit->value;
  if (by_name != kByName.end()) value = by_name->value;
  return in_meaning(parameter, value)
             ? value
             : 0.5 * (std::max(parameter.lower, -1.0) + std::min(parameter.upper, 1.0));
}

bool is_required(const models::ParameterInfo& parameter) {
  return !parameter.default_value && parameter.derived.empty();
}

/// The parameter to free: a number without a unit that has to be given, such as a drag coefficient; else one that has
/// to be given; else a number without a unit whose default is not zero; else the first.
const models::ParameterInfo& freed(const std::vector<models::ParameterInfo>& parameters) {
  const auto first = [&](const auto& suits) -> const models::ParameterInfo* {
    const auto found = std::ranges::find_if(parameters, suits);
    return found == parameters.end() ? nullptr : &*found;
  };
  for (const auto* found : {first([](const auto& p) { return is_required(p) && p.unit == "1"; }),
                            first([](const auto& p) { return p.name == "C_D" || p.name == "C_D90"; }),
                            first([](const auto& p) { return is_required(p); }), first([](const auto& p) {
                              return p.default_value.value_or(0.0) != 0.0 && p.unit == "1";
                            })})
    if (found != nullptr) return *found;
  return parameters.front();
}

std::string comment_of(const std::string& unit, const std::string& text) {
  const std::string suffix = unit_suffix(unit);
  return fmt::format("  #{}{}{}\n", suffix, suffix.empty() ? " " : ", ", printable(text));
}

std::string line(const std::string& key, const std::string& value, const std::string& comment) {
  return fmt::format("{} = {}{}", io::toml_key(key), value, comment);
}

std::string head(const models::ModelInfo& info, const std::string& name) {
  return fmt::format(
      "# {}\n# samara models {} explains it; docs/plans.md all that a plan may say.\nmodel = {}\ntitle = "
      "{}\n",
      printable(info.title), printable(name), quoted_toml(name), quoted_toml(printable(info.title)));
}

std::string tail(double end, const std::string& time_unit) {
  return fmt::format(
      "\n[time]\nend = {}{}\n[tolerance]\nrelative = 1e-3  # of the range of each output over the whole box\n"
      "# absolute = {{ .. }}  # least range of an output that counts\n\n[builder]\n# kind = \"pgd\"  # or "
      "\"sampling\"; "
      "chosen where nothing is said\n# threads = 2  # all that there are where nothing is said\n",
      number_text(end, 3), comment_of(time_unit, "from 0"));
}

/// The parameters of [fixed] and of [box].
std::string coordinates(const models::ModelInfo& info, const std::string& free_name) {
  std::string fixed = "\n[fixed]  # SI numbers, or with a unit: \"1.5 mm\"\n", box;
  for (const models::ParameterInfo& parameter : info.parameters) {
    const double value = sample_of(parameter);
    const std::string comment = comment_of(parameter.unit, parameter.description);
    if (parameter.name == free_name) {
      double lower = 0.9 * value, upper = 1.1 * value;
      if (value == 0.0) upper = 0.1;
      if (lower > upper) std::swap(lower, upper);
      box = line(
          parameter.name,
          fmt::format("[{}, {}]", number_text(lower, 6), number_text(std::min(upper, parameter.upper), 6)),
          comment);
    } else if (is_required(parameter)) {
      fixed += line(parameter.name, number_text(value), comment);
    } else {
      const std::string given = parameter.default_value ? number_text(value) : ".. ";
      fixed +=
          "# " + line(parameter.name, given,
                      comment_of(parameter.unit,
                                 parameter.description +
                                     (parameter.derived.empty() ? "" : "; default: " + parameter.derived)));
    }
  }
  return fixed + "\n[box]  # what is free, from .. to\n" + box;
}

/// A round number of the model's own time, two of them.
double end_of(const models::Model& model, const std::string& free_name) {
  models::ParameterValues values;
  for (const models::ParameterInfo& parameter : model.info().parameters) {
    values.given.push_back(is_required(parameter) || parameter.name == free_name ? 1 : 0);
    values.value.push_back(sample_of(parameter));
  }
  values.value = model.completed(values);
  const double time = 2.0 * model.scales(values).time;
  if (!(time > 0.0) || !std::isfinite(time)) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(time)));
  return std::round(time / power) * power;
}

}  // namespace

std::string plan_template(const models::Model& model, const std::string& name) {
  const models::ModelInfo& info = model.info();
  std::string text = head(info, name);
  std::string free_name;
  if (!info.parameters.empty()) {
    free_name = freed(info.parameters).name;
    text += coordinates(info, free_name);
  } else {
    text += "\n[box]  # what is free, from .. to\n";
  }
  bool is_first = info.parameters.empty();
  for (const models::StateInfo& state : info.states) {
    const double value = state.default_initial;
    const std::string ends =
        fmt::format("[{}, {}]", number_text(value - 0.1, 6), number_text(value + 0.1, 6));
    text +=
        (is_first ? "" : "# ") + line(state.name + "(0)", ends, comment_of(state.unit, state.description));
    is_first = false;
  }
  return text + tail(end_of(model, free_name), models::time_unit(info));
}

std::string plan_template(const models::FieldModel& field) {
  std::string text = head(field.info, field.info.name);
  std::vector<models::ParameterInfo> free;
  for (const models::ParameterInfo& parameter : field.info.parameters)
    if (parameter.name != field.extent) free.push_back(parameter);
  text += coordinates(field.info, freed(free).name);
  return text + tail(60.0, models::time_unit(field.info));
}

}  // namespace samara::codebooks
