#include "samara/codebooks/plan/plan_template.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "samara/base/names.h"
#include "samara/base/number_text.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/io/toml_edit.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/interface/parametric_model.h"

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
constexpr std::array<Sample, 9> kByUnit = {{{"kg", 1e-2},
                                            {"m", 1e-2},
                                            {"m^2", 1e-3},
                                            {"kg m^2", 1e-5},
                                            {"kg/m^3", 1000.0},
                                            {"K", 300.0},
                                            {"W/(m K)", 40.0},
                                            {"J/(m^3 K)", 3e6},
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

/// What is free, from .. to.
struct Interval {
  std::string name;
  double lower = 0.0, upper = 0.0;
};

Interval interval_of(const models::ParameterInfo& parameter) {
  const double value = sample_of(parameter);
  double lower = 0.9 * value, upper = 1.1 * value;
  if (value == 0.0) upper = 0.1;
  if (lower > upper) std::swap(lower, upper);
  if (!(lower > parameter.lower))
    lower = parameter.lower_inclusive ? parameter.lower : 0.5 * (parameter.lower + value);
  return {parameter.name, lower, std::min(upper, parameter.upper)};
}

Interval interval_of(const models::StateInfo& state) {
  return {state.name + "(0)", state.default_initial - 0.1, state.default_initial + 0.1};
}

std::string line(const Interval& interval, const std::string& comment) {
  return line(interval.name,
              fmt::format("[{}, {}]", number_text(interval.lower, 6), number_text(interval.upper, 6)),
              comment);
}

/// The parameters of [fixed] and of [box]. @param driven gets a value, whatever its default; empty: none
std::string coordinates(const models::ModelInfo& info, const std::string& free_name,
                        const std::string& driven = "") {
  std::string fixed = "\n[fixed]  # SI numbers, or with a unit: \"1.5 mm\"\n", box;
  for (const models::ParameterInfo& parameter : info.parameters) {
    const double value = sample_of(parameter);
    const std::string comment = comment_of(parameter.unit, parameter.description);
    if (parameter.name == free_name) {
      box = line(interval_of(parameter), comment);
    } else if (parameter.name == driven) {
      fixed += line(parameter.name, "10", comment);
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

/// With one digit.
double rounded(double time) {
  const double power = std::pow(10.0, std::floor(std::log10(time)));
  return std::round(time / power) * power;
}

/// Whether trajectories from both ends and the middle of the interval go on to the end.
bool trajectories_reach(double end, const models::Model& model, const Interval& free) {
  std::map<std::string, double> fixed;
  for (const models::ParameterInfo& parameter : model.info().parameters)
    if (is_required(parameter) && parameter.name != free.name) fixed[parameter.name] = sample_of(parameter);
  const std::shared_ptr<const models::Model> shared(std::shared_ptr<void>(), &model);
  const models::ParametricModel parametric(shared, fixed, {free.name});
  models::Integrator integrator(parametric, {.relative_tolerance = 1e-6}, false);
  const auto reaches = [&](double q) { return integrator(std::array{q}, std::array{0.0, end}).is_usable(); };
  return reaches(free.lower) && reaches(0.5 * (free.lower + free.upper)) && reaches(free.upper);
}

/// The time, or what is left of it by halving, that solutions of finite time all have; where none was found, the time.
double reached_end(double end, const models::Model& model, const Interval& free) {
  constexpr int kMostHalvings = 6;
  try {
    double shorter = end;
    for (int halving = 0; halving <= kMostHalvings; ++halving) {
      if (trajectories_reach(shorter, model, free)) return shorter;
      shorter = rounded(0.5 * shorter);
    }
  } catch (const std::exception&) {
    // What must be said of such a model first, or what it throws, is the reader's to see when he builds.
  }
  return end;
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
  return rounded(time);
}

}  // namespace

std::string plan_template(const models::Model& model, const std::string& name) {
  const models::ModelInfo& info = model.info();
  std::string text = head(info, name);
  std::optional<Interval> free;
  if (!info.parameters.empty()) {
    free = interval_of(freed(info.parameters));
    text += coordinates(info, free->name);
  } else {
    text += "\n[box]  # what is free, from .. to\n";
  }
  for (const models::StateInfo& state : info.states) {
    text += (free ? "# " : "") + line(interval_of(state), comment_of(state.unit, state.description));
    if (!free) free = interval_of(state);
  }
  const double end = reached_end(end_of(model, free->name), model, *free);
  return text + tail(end, models::time_unit(info));
}

std::string plan_template(const models::FieldModel& field) {
  std::string text = head(field.info, field.info.name);
  std::vector<models::ParameterInfo> free;
  for (const models::ParameterInfo& parameter : field.info.parameters)
    if (parameter.name != field.extent) free.push_back(parameter);
  // Where all that a field is linear in is zero, so is the field.
  const auto is_zero = [&](const models::ParameterInfo& parameter) {
    return std::ranges::find(field.linear_in, parameter.name) == field.linear_in.end() ||
           parameter.default_value == 0.0;
  };
  const bool is_nothing = !field.linear_in.empty() && std::ranges::all_of(free, is_zero);
  text += coordinates(field.info, freed(free).name, is_nothing ? field.linear_in.back() : "");
  return text + tail(60.0, models::time_unit(field.info));
}

}  // namespace samara::codebooks
