#include "samara/base/units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/base/unit_factors.h"

namespace samara {

namespace {

struct Symbol {
  std::string_view text;
  Unit unit;
  bool takes_prefix = false;
};

constexpr double kPi = std::numbers::pi;

// In the order in which a suggestion prefers them.
const std::array<Symbol, 28> kSymbols = {{
    {"m", {1.0, 0, {.metre = 1}}, true},
    {"s", {1.0, 0, {.second = 1}}, true},
    {"g", {1.0, -3, {.kilogram = 1}}, true},
    {"rad", {}, true},
    {"deg", {kPi / 180.0, 0, {}}},
    {"K", {1.0, 0, {.kelvin = 1}}, true},
    {"N", {1.0, 0, {.metre = 1, .kilogram = 1, .second = -2}}, true},
    {"Pa", {1.0, 0, {.metre = -1, .kilogram = 1, .second = -2}}, true},
    {"J", {1.0, 0, {.metre = 2, .kilogram = 1, .second = -2}}, true},
    {"W", {1.0, 0, {.metre = 2, .kilogram = 1, .second = -3}}, true},
    {"Hz", {1.0, 0, {.second = -1}}, true},
    {"px", {1.0, 0, {.pixel = 1}}},
    {"frame", {1.0, 0, {.frame = 1}}},
    {"min", {60.0, 0, {.second = 1}}},
    {"h", {3600.0, 0, {.second = 1}}},
    {"rpm", {kPi / 30.0, 0, {.second = -1}}},
    {"rev", {2.0 * kPi, 0, {}}},
    {"%", {1.0, -2, {}}},
    {"l", {1.0, -3, {.metre = 3}}, true},
    {"L", {1.0, -3, {.metre = 3}}, true},
    {"bar", {1.0, 5, {.metre = -1, .kilogram = 1, .second = -2}}, true},
    {"\u00B0", {kPi / 180.0, 0, {}}},
    {"in", {2.54, -2, {.metre = 1}}},
    {"ft", {30.48, -2, {.metre = 1}}},
    {"lb", {0.45359237, 0, {.kilogram = 1}}},
    // Without prefixes: pA is more often a slip for Pa.
    {"A", {1.0, 0, {.ampere = 1}}},
    {"mol", {1.0, 0, {.mole = 1}}},
    {"cd", {1.0, 0, {.candela = 1}}},
}};

// With their powers of ten, in the order in which a suggestion prefers them.
constexpr std::array<std::pair<std::string_view, int>, 15> kPrefixes = {{{"k", 3},
                                                                         {"c", -2},
                                                                         {"m", -3},
                                                                         {"M", 6},
                                                                         {"u", -6},
                                                                         {"\u00B5", -6},
                                                                         {"\u03BC", -6},
                                                                         {"n", -9},
                                                                         {"h", 2},
                                                                         {"da", 1},
                                                                         {"d", -1},
                                                                         {"G", 9},
                                                                         {"T", 12},
                                                                         {"p", -12},
                                                                         {"f", -15}}};

using Exponent = int Dimension::*;
constexpr std::array<std::pair<Exponent, std::string_view>, 9> kBaseQuantities = {
    {{&Dimension::kilogram, "kg"},
     {&Dimension::metre, "m"},
     {&Dimension::second, "s"},
     {&Dimension::kelvin, "K"},
     {&Dimension::ampere, "A"},
     {&Dimension::mole, "mol"},
     {&Dimension::candela, "cd"},
     {&Dimension::pixel, "px"},
     {&Dimension::frame, "frame"}}};

/// `left` times `right`^exponent.
Unit times_power(const Unit& left, const Unit& right, int exponent) {
  Unit product = left;
  for (int k = 0; k < std::abs(exponent); ++k) {
    product.coefficient =
        exponent > 0 ? product.coefficient * right.coefficient : product.coefficient / right.coefficient;
  }
  product.power_of_ten += exponent * right.power_of_ten;
  for (const auto& [base, name] : kBaseQuantities) {
    product.dimension.*base += exponent * right.dimension.*base;
  }
  return product;
}

std::optional<Unit> find_symbol(std::string_view text) {
  for (const Symbol& symbol : kSymbols) {
    if (symbol.text == text) return symbol.unit;
  }
  for (const auto& [prefix, power] : kPrefixes) {
    if (!text.starts_with(prefix)) continue;
    for (const Symbol& symbol : kSymbols) {
      if (!symbol.takes_prefix || symbol.text != text.substr(prefix.size())) continue;
      Unit unit = symbol.unit;
      unit.power_of_ten += power;
      return unit;
    }
  }
  return std::nullopt;
}

bool is_celsius(std::string_view text) {
  return text == "degC" || text == "\u00B0C";
}

/// Names that are words or signs for what has a symbol.
struct OtherName {
  std::string_view text, symbol;
};
constexpr std::array<OtherName, 21> kOtherNames = {
    {{"inch", "in"},    {"inches", "in"},   {"\"", "in"},      {"foot", "ft"}, {"feet", "ft"},
     {"'", "ft"},       {"pound", "lb"},    {"pounds", "lb"},  {"lbs", "lb"},  {"lbm", "lb"},
     {"metre", "m"},    {"meter", "m"},     {"second", "s"},   {"sec", "s"},   {"seconds", "s"},
     {"degree", "deg"}, {"degrees", "deg"}, {"minute", "min"}, {"hour", "h"},  {"gram", "g"},
     {"litre", "l"}}};

/// "; did you mean ..." for an unknown symbol.
std::string unit_suggestion(std::string_view text) {
  if (is_celsius(text))
    return ": a scale with an offset stands alone after the number of a temperature, as in \"20 degC\"";
  for (const std::string_view celsius : {"C", "Celsius", "celsius"}) {
    if (text == celsius) return "; did you mean \"degC\"?";
  }
  for (const OtherName& other : kOtherNames) {
    if (text == other.text) return "; did you mean \"" + std::string(other.symbol) + "\"?";
  }
  std::vector<std::string> plain;
  std::vector<std::string> known;
  for (const Symbol& symbol : kSymbols) {
    plain.emplace_back(symbol.text);
    known.emplace_back(symbol.text);
  }
  for (const auto& [prefix, power] : kPrefixes) {
    for (const Symbol& symbol : kSymbols) {
      if (symbol.takes_prefix) known.push_back(std::string(prefix) + std::string(symbol.text));
    }
  }
  // A wrong capital is the likeliest slip, and edit distance alone takes "KG" for anything with two letters.
  for (const std::string& candidate : known) {
    if (lower_case(candidate) == lower_case(text)) return "; did you mean \"" + candidate + "\"?";
  }
  const std::string nearest = nearest_name(text, known);
  return nearest.empty() ? suggestion(text, plain) : "; did you mean \"" + nearest + "\"?";
}

/// @param what the text to name in errors, quoted
Unit parse(std::string_view text, std::string_view what) {
  const std::string where = std::string(what) + ": ";
  Unit unit;
  for (const UnitFactor& factor : unit_factors(text, what)) {
    const std::optional<Unit> known = find_symbol(factor.symbol);
    if (!known) {
      throw ArgumentError(where + "unknown unit " + in_quotes(factor.symbol) +
                          unit_suggestion(factor.symbol));
    }
    unit = times_power(unit, *known, factor.exponent);
  }
  constexpr int kLargest = 300;
  bool small = std::abs(unit.power_of_ten) <= kLargest && std::isnormal(unit.coefficient);
  for (const auto& [base, name] : kBaseQuantities)
    small = small && std::abs(unit.dimension.*base) <= kLargest;
  if (!small) throw ArgumentError(where + "the unit is beyond any use");
  return unit;
}

/// 10^n for n >= 0; exact up to n = 22.
double power_of_ten(int n) {
  return std::pow(10.0, n);
}

}  // namespace

std::string to_string(const Dimension& dimension) {
  std::string text;
  for (const auto& [base, name] : kBaseQuantities) {
    const int exponent = dimension.*base;
    if (exponent == 0) continue;
    if (!text.empty()) text += ' ';
    text += name;
    if (exponent == 1) continue;
    text += '^';
    text += std::to_string(exponent);
  }
  return text.empty() ? "1" : text;
}

double Unit::to_si(double value) const {
  const double scaled = value * coefficient;
  return power_of_ten >= 0 ? scaled * samara::power_of_ten(power_of_ten)
                           : scaled / samara::power_of_ten(-power_of_ten);
}

double Unit::from_si(double value) const {
  const double scaled = value / coefficient;
  return power_of_ten >= 0 ? scaled / samara::power_of_ten(power_of_ten)
                           : scaled * samara::power_of_ten(-power_of_ten);
}

Unit parse_unit(std::string_view text) {
  return parse(text, "unit " + in_quotes(text));
}

bool is_coherent_si(std::string_view text) {
  try {
    const Unit unit = parse(text, "");
    return unit.factor() == 1.0 && unit.dimension.pixel == 0 && unit.dimension.frame == 0;
  } catch (const ArgumentError&) {
    return false;
  }
}

bool same_dimension(std::string_view first_unit, std::string_view second_unit) {
  return parse_unit(first_unit).dimension == parse_unit(second_unit).dimension;
}

namespace {

enum class QuantityKind { value, difference };

double to_si(std::string_view text, std::string_view expected_unit, QuantityKind kind) {
  const std::string what = in_quotes(text);
  const Dimension expected = parse_unit(expected_unit).dimension;
  const std::string_view body = trimmed(text);
  const NumberPrefix number = read_number(body);
  const std::string_view rest = trimmed(body.substr(number.length));
  const bool torn = !rest.empty() &&
                    std::string_view(".,+-0123456789").find(rest.front()) != std::string_view::npos &&
                    rest.data() == body.data() + number.length;
  if (number.problem == NumberProblem::malformed || torn) {
    if (expected.is_dimensionless()) throw ArgumentError(what + ": expected a number, as in 1.5");
    throw ArgumentError(what + ": expected a number with a unit, as in \"1.5 " + std::string(expected_unit) +
                        "\"");
  }
  if (number.problem != NumberProblem::none) throw ArgumentError(what + ": expected a finite number");
  if (rest.empty()) {
    if (expected.is_dimensionless()) return number.value;
    throw ArgumentError(what + ": the unit is missing, expected one like " + std::string(expected_unit));
  }
  constexpr Dimension kTemperature = {.kelvin = 1};
  if (is_celsius(rest) && expected == kTemperature) {
    if (kind == QuantityKind::difference)
      throw ArgumentError(what + ": a difference of temperatures is given in K");
    constexpr double kZeroCelsius = 273.15;  // K
    return number.value + kZeroCelsius;
  }
  const Unit unit = parse(is_celsius(rest) ? "K" : rest, what);
  if (unit.dimension != expected) {
    const std::string wanted = to_string(expected);
    throw ArgumentError(what + " has the dimension " + to_string(unit.dimension) + ", expected " +
                        (expected.is_dimensionless() ? "a plain number"
                         : wanted == expected_unit
                             ? wanted
                             : "that of " + std::string(expected_unit) + ", " + wanted));
  }
  const double value = unit.to_si(number.value);
  if (!std::isfinite(value)) throw ArgumentError(what + ": the value in SI is too large");
  return value;
}

}  // namespace

double quantity_to_si(std::string_view text, std::string_view expected_unit) {
  return to_si(text, expected_unit, QuantityKind::value);
}

double difference_to_si(std::string_view text, std::string_view expected_unit) {
  return to_si(text, expected_unit, QuantityKind::difference);
}

}  // namespace samara
