#include "inputs/assignments.h"

#include <charconv>
#include <cmath>
#include <ranges>
#include <string_view>

#include <fmt/format.h>

#include "inputs/value_lists.h"
#include "samara/base/errors.h"
#include "samara/base/limits.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/base/unit_labels.h"
#include "samara/base/units.h"

namespace samara::apps {

namespace {

using ToSi = double (*)(std::string_view, std::string_view);

double any_number_or_quantity(const std::string& what, const std::string& text, const std::string& unit,
                              ToSi to_si) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [rest, problem] = std::from_chars(text.data(), end, value);
  if (problem == std::errc() && rest == end) {
    if (!std::isfinite(value))
      throw ArgumentError(fmt::format("{} is {}, expected a finite number", what, text));
    return value;
  }
  try {
    return to_si(text, unit);
  } catch (const ArgumentError& error) {
    throw ArgumentError(fmt::format("{}: {}", what, error.what()));
  }
}

double small_enough(const std::string& what, const std::string& text, double value) {
  if (std::abs(value) <= kLargestInput) return value;
  throw ArgumentError(fmt::format("{} is {}, expected at most {} in size", what, text, kLargestInput));
}

}  // namespace

double number_or_quantity(const std::string& what, const std::string& text, const std::string& unit) {
  return small_enough(what, text, any_number_or_quantity(what, text, unit, quantity_to_si));
}

double positive_quantity(const std::string& what, const std::string& text, const std::string& unit) {
  const double value = number_or_quantity(what, text, unit);
  if (value > 0.0) return value;
  throw ArgumentError(fmt::format("{} is {}, expected more than 0", what, text));
}

double number_or_difference(const std::string& what, const std::string& text, const std::string& unit) {
  return small_enough(what, text, any_number_or_quantity(what, text, unit, difference_to_si));
}

Setting setting_of(const std::string& option, const std::string& text) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos)
    throw ArgumentError(fmt::format("{} \"{}\" has no \"=\", expected NAME=VALUE", option, text));
  return {text.substr(0, sign), text.substr(sign + 1)};
}

EndTexts ends_of(const std::string& text) {
  const std::size_t dots = text.find("..");
  EndTexts ends = {std::string(trimmed(std::string_view(text).substr(0, dots))), std::nullopt};
  if (dots == std::string::npos) return ends;
  ends.upper = std::string(trimmed(std::string_view(text).substr(dots + 2)));
  const std::string unit = unit_behind(*ends.upper);
  if (!ends.lower.empty() && !unit.empty() && unit_behind(ends.lower).empty()) ends.lower += " " + unit;
  return ends;
}

models::Interval interval_of(const std::string& name, const std::string& text, const std::string& unit) {
  const EndTexts ends = ends_of(text);
  const double lower = number_or_quantity(name, ends.lower, unit);
  return {lower, ends.upper ? number_or_quantity(name, *ends.upper, unit) : lower};
}

Eigen::Vector3d place_of(const std::string& option, const std::string& text, const std::string& directions) {
  std::vector<double> numbers;
  for (const auto part : std::views::split(text, ',')) {
    const std::string number(trimmed({part.begin(), part.end()}));
    numbers.push_back(number_or_quantity(option, number, "m"));
  }
  if (numbers.size() != 3) {
    throw ArgumentError(fmt::format("{} is \"{}\", {} numbers; 3 were expected: {}", option, text,
                                    numbers.size(), directions));
  }
  return {numbers[0], numbers[1], numbers[2]};
}

std::string full_name(const std::string& name, const std::vector<std::string>& known) {
  if (contains(known, name) || name.size() < 2 || name.back() != '0') return name;
  std::string state = name.substr(0, name.size() - 1);
  if (state.back() == '@') state.pop_back();
  const std::string initial = state + "(0)";
  return contains(known, initial) ? initial : name;
}

std::string shell_name(const std::string& name, const std::vector<std::string>& known) {
  if (!name.ends_with("(0)")) return name;
  const std::string plain = name.substr(0, name.size() - 3) + "0";
  return contains(known, plain) ? name : plain;
}

void require_parameters(const std::string& source, const models::ModelInfo& info,
                        const std::map<std::string, double>& values) {
  std::string missing;
  for (const models::ParameterInfo& p : info.parameters) {
    if (values.contains(p.name) || p.default_value || !p.derived.empty()) continue;
    missing += fmt::format("{}--set {}=..{}", missing.empty() ? "" : ", ", p.name, unit_suffix(p.unit));
  }
  if (missing.empty()) return;
  throw ArgumentError(fmt::format("the model \"{}\" needs more: {}; samara models {} explains them",
                                  info.name, missing, source));
}

std::map<std::string, double> parse_assignments(const std::vector<std::string>& texts,
                                                const std::map<std::string, std::string>& units,
                                                const std::string& option) {
  std::vector<std::string> known;
  for (const auto& [name, unit] : units) known.push_back(name);
  std::map<std::string, double> values;
  for (const std::string& text : texts) {
    const auto [typed, given] = setting_of(option, text);
    const std::string name = full_name(typed, known);
    const auto unit = units.find(name);
    if (unit == units.end()) {
      throw ArgumentError(fmt::format("{}: unknown name \"{}\"{}", option, name, suggestion(name, known)));
    }
    const double value =
        number_or_quantity(option == "--set" ? name : option + ": " + name, given, unit->second);
    if (!values.emplace(name, value).second)
      throw ArgumentError(fmt::format("{}: \"{}\" is set twice", option, name));
  }
  return values;
}

}  // namespace samara::apps
