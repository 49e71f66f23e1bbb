#include "samara/pgd/fields/unit_algebra.h"

#include <cctype>
#include <charconv>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace samara::pgd {

namespace {

using Powers = std::vector<std::pair<std::string, int>>;

void multiply(Powers& powers, const std::string& symbol, int exponent) {
  for (auto& [known, sum] : powers) {
    if (known != symbol) continue;
    sum += exponent;
    return;
  }
  powers.emplace_back(symbol, exponent);
}

/// One factor, "m" or "s^-2"; false if it is none.
bool add_factor(std::string_view factor, int sign, Powers& powers) {
  if (factor == "1") return true;
  const std::size_t caret = factor.find('^');
  const std::string_view symbol = factor.substr(0, caret);
  int exponent = 1;
  if (caret != std::string_view::npos) {
    const char* end = factor.data() + factor.size();
    const auto [rest, error] = std::from_chars(factor.data() + caret + 1, end, exponent);
    if (error != std::errc() || rest != end) return false;
  }
  for (const char c : symbol) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 128 && !std::isalpha(byte) && c != '%') return false;
  }
  if (symbol.empty()) return false;
  multiply(powers, std::string(symbol), sign * exponent);
  return true;
}

/// Symbols and exponents, or nothing if the text has another form.
std::optional<Powers> parse(std::string_view text) {
  Powers powers;
  int sign = 1;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find_first_of(" */", begin);
    const std::string_view factor = text.substr(begin, end == std::string_view::npos ? end : end - begin);
    if (!add_factor(factor, sign, powers)) return std::nullopt;
    if (end == std::string_view::npos) return powers;
    // "W/m K" is ambiguous: after a slash only another slash is clear.
    if (text[end] != '/' && sign < 0) return std::nullopt;
    if (text[end] == '/') sign = -1;
    begin = end + 1;
  }
}

/// "kg m/s^2": positive powers, then one symbol after a slash; several take negative exponents.
std::string write(const Powers& powers) {
  std::string above;
  std::string below;
  int divisors = 0;
  for (const auto& [symbol, exponent] : powers) divisors += exponent < 0 ? 1 : 0;
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

/// a times b^power.
std::string combine(std::string_view a, std::string_view b, int power) {
  const std::optional<Powers> first = parse(a);
  const std::optional<Powers> second = parse(b);
  if (!first || !second) {
    if (b == "1") return std::string(a);
    return fmt::format("({}){}({})", a, power < 0 ? "/" : " ", b);
  }
  Powers powers = *first;
  for (const auto& [symbol, exponent] : *second) multiply(powers, symbol, power * exponent);
  return write(powers);
}

}  // namespace

std::string unit_product(std::string_view a, std::string_view b) {
  return combine(a, b, 1);
}
std::string unit_quotient(std::string_view a, std::string_view b) {
  return combine(a, b, -1);
}

}  // namespace samara::pgd
