#include "samara/models/equations/unit_powers.h"

#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

namespace samara::models {

namespace {

/// Powers beyond which nothing is measured.
constexpr int kLargestPower = 1000;
constexpr std::array kBaseUnits = {"m", "kg", "s", "K", "A", "mol", "cd", "px", "frame"};

}  // namespace

UnitPowers::UnitPowers(const Dimension& d)
    : powers_{d.metre, d.kilogram, d.second, d.kelvin, d.ampere, d.mole, d.candela, d.pixel, d.frame} {}

UnitPowers UnitPowers::times(const UnitPowers& other, int sign) const {
  UnitPowers product = *this;
  for (std::size_t k = 0; k < powers_.size(); ++k) product.powers_[k] += sign * other.powers_[k];
  return product;
}

std::optional<UnitPowers> UnitPowers::raised(Power exponent) const {
  UnitPowers result;
  for (std::size_t k = 0; k < powers_.size(); ++k) {
    result.powers_[k] = powers_[k] * exponent;
    if (std::abs(result.powers_[k].numerator()) > kLargestPower ||
        result.powers_[k].denominator() > kLargestPower)
      return std::nullopt;
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
