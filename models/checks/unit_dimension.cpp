#include "samara/models/checks/unit_dimension.h"

#include <algorithm>
#include <charconv>

namespace samara::models {

namespace {

bool is_symbol_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

struct Factor {
  std::string_view symbol;
  int power = 1;
};

/// A symbol with or without an integer power, such as "m^2".
std::optional<Factor> read_factor(std::string_view text) {
  const std::size_t hat = text.find('^');
  Factor factor = {.symbol = text.substr(0, hat)};
  if (factor.symbol.empty() || !std::ranges::all_of(factor.symbol, is_symbol_letter)) return std::nullopt;
  if (hat == std::string_view::npos) return factor;
  const std::string_view power = text.substr(hat + 1);
  const auto [end, error] = std::from_chars(power.data(), power.data() + power.size(), factor.power);
  if (error != std::errc() || end != power.data() + power.size()) return std::nullopt;
  return factor;
}

/// Calls `use` for every factor, powers below a "/" negated; false if the text is no unit or `use` says so.
template <class Use>
bool for_each_factor(std::string_view unit, Use use) {
  if (unit == "1") return true;
  bool below = unit.starts_with("1/");
  if (below) unit.remove_prefix(2);
  while (true) {
    const std::size_t end = unit.find_first_of(" */");
    std::optional<Factor> factor = read_factor(unit.substr(0, end));
    if (!factor) return false;
    if (below) factor->power = -factor->power;
    if (!use(*factor)) return false;
    if (end == std::string_view::npos) return true;
    below = unit[end] == '/';
    unit.remove_prefix(end + 1);
  }
}

struct KnownUnit {
  std::string_view symbol;
  Dimension dimension;
};

constexpr std::array<KnownUnit, 13> kKnown = {{
    {"m", {1, 0, 0}},
    {"kg", {0, 1, 0}},
    {"s", {0, 0, 1}},
    {"rad", {0, 0, 0}},
    {"N", {1, 1, -2}},
    {"J", {2, 1, -2}},
    {"W", {2, 1, -3}},
    {"Pa", {-1, 1, -2}},
    {"Hz", {0, 0, -1}},
    {"K", {0, 0, 0}},
    {"A", {0, 0, 0}},
    {"mol", {0, 0, 0}},
    {"cd", {0, 0, 0}},
}};

}  // namespace

bool looks_like_a_unit(std::string_view unit) {
  return for_each_factor(unit, [](const Factor&) { return true; });
}

std::optional<Dimension> dimension_of(std::string_view unit) {
  Dimension sum = {};
  const bool known = for_each_factor(unit, [&](const Factor& factor) {
    const auto* const entry = std::ranges::find(kKnown, factor.symbol, &KnownUnit::symbol);
    if (entry == kKnown.end()) return false;
    for (std::size_t b = 0; b < sum.size(); ++b) sum[b] += factor.power * entry->dimension[b];
    return true;
  });
  return known ? std::optional(sum) : std::nullopt;
}

}  // namespace samara::models
