#include "samara/io/units.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/io/text.h"

namespace samara::io {

namespace {

struct Symbol {
  std::string_view text;
  Unit unit;
  bool takes_prefix = false;
};

constexpr double kPi = std::numbers::pi;

// In the order in which a suggestion prefers them.
const std::array<Symbol, 22> kSymbols = {{
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
constexpr std::array<std::pair<Exponent, std::string_view>, 6> kBaseQuantities = {
    {{&Dimension::kilogram, "kg"},
     {&Dimension::metre, "m"},
     {&Dimension::second, "s"},
     {&Dimension::kelvin, "K"},
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

/// "; did you mean ..." for an unknown symbol.
std::string unit_suggestion(std::string_view text) {
  for (const std::string_view celsius : {"degC", "C", "\u00B0C", "Celsius", "celsius"}) {
    if (text == celsius) return "; a temperature is given in K";
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

std::string replace_all(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

/// Typographic forms in plain ASCII.
std::string plain_form(std::string_view text) {
  std::string plain(text);
  for (const auto& [typographic, ascii] :
       {std::pair<std::string_view, std::string_view>{"\u207B\u00B9", "^-1"},
        {"\u207B\u00B2", "^-2"},
        {"\u207B\u00B3", "^-3"},
        {"\u207B\u2074", "^-4"},
        {"\u00B2", "^2"},
        {"\u00B3", "^3"},
        {"\u2074", "^4"},
        {"\u00B7", "*"},
        {"\u22C5", "*"},
        {"**", "^"}}) {
    plain = replace_all(std::move(plain), typographic, ascii);
  }
  return plain;
}

/// Recursive descent over
///   expression = factor { ("*" | blank | "/") factor }
///   factor     = ( "1" | symbol | "(" expression ")" ) [ ["^"] integer ]
class UnitParser {
 public:
  /// @param what the text to name in errors, quoted
  UnitParser(std::string_view text, std::string what) : text_(plain_form(text)), what_(std::move(what)) {
    constexpr std::size_t kLongest = 200;  // bounds the recursion
    if (text_.size() > kLongest) fail("the unit is longer than 200 characters");
  }

  Unit parse() {
    skip_blanks();
    if (at_end()) fail("the unit is empty; write 1 for a dimensionless one");
    const Unit unit = expression();
    if (!at_end()) fail("unexpected " + in_quotes(std::string_view(text_).substr(at_)) + " in the unit");
    return unit;
  }

 private:
  [[noreturn]] void fail(const std::string& sentence) const { throw ArgumentError(what_ + ": " + sentence); }
  bool at_end() const { return at_ == text_.size(); }
  char next() const { return at_end() ? '\0' : text_[at_]; }
  void skip_blanks() {
    while (next() == ' ' || next() == '\t') ++at_;
  }

  Unit expression() {
    Unit unit = times_power(Unit{}, factor(), 1);
    bool divided = false;
    for (skip_blanks(); !at_end() && next() != ')'; skip_blanks()) {
      const bool divide = next() == '/';
      if (divide || next() == '*') {
        ++at_;
        skip_blanks();
      }
      if (divided && !divide) fail("a product after a slash is ambiguous; write parentheses, as in W/(m K)");
      divided = divided || divide;
      unit = bounded(times_power(unit, factor(), divide ? -1 : 1));
    }
    return unit;
  }

  Unit factor() {
    skip_blanks();
    if (next() == '(') {
      ++at_;
      const Unit inner = expression();
      if (next() != ')') fail("a closing parenthesis is missing in the unit");
      ++at_;
      return bounded(times_power(Unit{}, inner, exponent()));
    }
    if (next() == '1') {
      ++at_;
      return Unit{};
    }
    const Unit unit = symbol();
    return bounded(times_power(Unit{}, unit, exponent()));
  }

  /// Nested powers could overflow.
  Unit bounded(const Unit& unit) const {
    constexpr int kLargest = 300;
    bool small = std::abs(unit.power_of_ten) <= kLargest && std::isnormal(unit.coefficient);
    for (const auto& [base, name] : kBaseQuantities)
      small = small && std::abs(unit.dimension.*base) <= kLargest;
    if (!small) fail("the unit is beyond any use");
    return unit;
  }

  Unit symbol() {
    const std::size_t begin = at_;
    while (!at_end() && std::string_view(" \t*/^()+-.,0123456789").find(next()) == std::string_view::npos)
      ++at_;
    const std::string_view name = std::string_view(text_).substr(begin, at_ - begin);
    if (name.empty() && at_end()) fail("the unit ends where a symbol was expected");
    if (name.empty()) fail("expected a unit symbol, found " + in_quotes(std::string_view(text_).substr(at_)));
    const std::optional<Unit> unit = find_symbol(name);
    if (!unit) fail("unknown unit " + in_quotes(name) + unit_suggestion(name));
    return *unit;
  }

  int exponent() {
    const bool caret = next() == '^';
    if (caret) ++at_;
    const bool negative = next() == '-';
    if (negative || next() == '+') ++at_;
    const std::size_t begin = at_;
    int value = 0;
    while (std::isdigit(static_cast<unsigned char>(next())) != 0 && value < 100)
      value = 10 * value + (text_[at_++] - '0');
    if (at_ == begin && !caret && !negative) return 1;
    if (at_ == begin || next() == '.') fail("an exponent in the unit is not a whole number");
    constexpr int kLargest = 12;
    if (value > kLargest) fail("an exponent in the unit is beyond " + std::to_string(kLargest));
    return negative ? -value : value;
  }

  std::string text_;
  std::string what_;
  std::size_t at_ = 0;
};

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
  return power_of_ten >= 0 ? scaled * io::power_of_ten(power_of_ten)
                           : scaled / io::power_of_ten(-power_of_ten);
}

double Unit::from_si(double value) const {
  const double scaled = value / coefficient;
  return power_of_ten >= 0 ? scaled / io::power_of_ten(power_of_ten)
                           : scaled * io::power_of_ten(-power_of_ten);
}

Unit parse_unit(std::string_view text) {
  return UnitParser(text, "unit " + in_quotes(text)).parse();
}

bool same_dimension(std::string_view first_unit, std::string_view second_unit) {
  return parse_unit(first_unit).dimension == parse_unit(second_unit).dimension;
}

double quantity_to_si(std::string_view text, std::string_view expected_unit) {
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
  const Unit unit = UnitParser(rest, what).parse();
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

}  // namespace samara::io
