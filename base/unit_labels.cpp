#include "samara/base/unit_labels.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/unit_factors.h"

namespace samara {

namespace {

using Powers = std::vector<UnitFactor>;

/// Letters, the percent sign and whatever is not ASCII: an underscore belongs to a name, not to a unit.
bool is_symbol(std::string_view text) {
  return std::ranges::all_of(text, [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 128 || std::isalpha(byte) != 0 || c == '%';
  });
}

void multiply(Powers& powers, const UnitFactor& factor, int sign) {
  const auto known = std::ranges::find(powers, factor.symbol, &UnitFactor::symbol);
  if (known != powers.end()) {
    known->exponent += sign * factor.exponent;
  } else {
    powers.push_back({factor.symbol, sign * factor.exponent});
  }
}

/// Symbols and exponents, or nothing if the text is no unit.
std::optional<Powers> read(std::string_view text) {
  try {
    Powers powers;
    for (const UnitFactor& factor : unit_factors(text, "")) {
      if (!is_symbol(factor.symbol)) return std::nullopt;
      multiply(powers, factor, 1);
    }
    return powers;
  } catch (const ArgumentError&) {
    return std::nullopt;
  }
}

/// "kg m/s^2": positive powers, then one symbol after a slash; several take negative exponents.
std::string write(const Powers& powers) {
  std::string above;
  std::string below;
  const auto divisors = std::ranges::count_if(powers, [](const UnitFactor& f) { return f.exponent < 0; });
  for (const auto& [symbol, exponent] : powers) {
    if (exponent == 0) continue;
    const bool slash = exponent < 0 && divisors == 1;
    const int shown = slash ? -exponent : exponent;
    std::string& side = slash ? below : above;
    if (!side.empty()) side.push_back(' ');
    side += shown == 1 ? symbol : fmt::format("{}^{}", symbol, shown);
  }
  if (above.empty()) above.push_back('1');
  return below.empty() ? above : fmt::format("{}/{}", above, below);
}

/// a times b^sign.
std::string combine(std::string_view a, std::string_view b, int sign) {
  if (b == "1") return std::string(a);
  std::optional<Powers> powers = read(a);
  const std::optional<Powers> second = read(b);
  if (!powers || !second) {
    return fmt::format("({}){}({})", a, sign < 0 ? "/" : " ", b);
  }
  for (const UnitFactor& factor : *second) multiply(*powers, factor, sign);
  return write(*powers);
}

}  // namespace

bool reads_as_unit(std::string_view text) {
  return read(text).has_value();
}

std::string unit_product(std::string_view a, std::string_view b) {
  return combine(a, b, 1);
}
std::string unit_quotient(std::string_view a, std::string_view b) {
  return combine(a, b, -1);
}

std::string unit_suffix(std::string_view unit) {
  return unit == "1" ? std::string() : std::string(" ").append(unit);
}

std::string shown_unit(std::string_view unit) {
  return unit == "1" ? "-" : std::string(unit);
}

}  // namespace samara
