#include "samara/models/equations/unit_powers.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::models {

namespace {

/// Powers beyond which nothing is measured.
constexpr int kLargestPower = 1000;
constexpr std::array kBaseUnits = {"m", "kg", "s", "K", "A", "mol", "cd", "px", "frame"};

bool is_measured(const UnitPowers::Power& power) {
  return std::abs(power.numerator()) <= kLargestPower && power.denominator() <= kLargestPower;
}

}  // namespace

UnitPowers::UnitPowers(const Dimension& d)
    : powers_{d.metre, d.kilogram, d.second, d.kelvin, d.ampere, d.mole, d.candela, d.pixel, d.frame} {}

UnitPowers UnitPowers::times(const UnitPowers& other, int sign) const {
  UnitPowers product = *this;
  for (std::size_t k = 0; k < powers_.size(); ++k) product.powers_[k] += sign * other.powers_[k];
  if (!std::ranges::all_of(product.powers_, is_measured))
    throw ArgumentError(fmt::format("a product is measured in {}, expected powers of at most {}",
                                    to_string(product), kLargestPower));
  return product;
}

std::optional<UnitPowers> UnitPowers::raised(Power exponent) const {
  UnitPowers result;
  for (std::size_t k = 0; k < powers_.size(); ++k) {
    result.powers_[k] = powers_[k] * exponent;
    if (!is_measured(result.powers_[k])) return std::nullopt;
  }
  return result;
}

std::string to_string(const UnitPowers& powers) {
  std::string text;
  for (std::size_t k = 0; k < kBaseUnits.size(); ++k) {
    const UnitPowers::Power& power = powers.powers_[k];
    if (power.numerator() == 0) continue;
    if (!text.empty()) text += " ";
    text += kBaseUnits[k];
    if (power.denominator() != 1) {
      text += fmt::format("^({}/{})", power.numerator(), power.denominator());
    } else if (power.numerator() != 1) {
      text += fmt::format("^{}", power.numerator());
    }
  }
  return text.empty() ? "1" : text;
}

std::optional<UnitPowers::Power> fraction_of(double number) {
  constexpr int kLargestDenominator = 12;
  if (!(std::abs(number) <= kLargestPower)) return std::nullopt;
  for (int denominator = 1; denominator <= kLargestDenominator; ++denominator) {
    const double numerator = number * denominator;
    if (std::abs(numerator - std::round(numerator)) < 1e-12)
      return UnitPowers::Power(static_cast<int>(std::round(numerator)), denominator);
  }
  return std::nullopt;
}

}  // namespace samara::models
