#include "samara/base/rounded.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace samara {

namespace {

constexpr int kErrorDigits = 2, kMostDigits = 6;

bool is_error(const std::optional<double>& error) {
  return error && std::isfinite(*error) && *error > 0.0;
}

int first_power(double value) {
  return value == 0.0 ? -300 : static_cast<int>(std::floor(std::log10(std::abs(value))));
}

/// The power of ten of the last digit that counts.
int last_power(double error) {
  // Rounded first: 0.0996 is 0.10.
  const int power = static_cast<int>(std::floor(std::log10(error)));
  const double scale = std::pow(10.0, power - kErrorDigits + 1);
  return static_cast<int>(std::floor(std::log10(std::round(error / scale) * scale) + 1e-9)) - kErrorDigits +
         1;
}

/// To that power, plainly where that is short, else with an exponent.
std::string rounded_to(double value, int power) {
  constexpr double kMost = 1e6;
  constexpr int kMostDecimals = 7;
  if (std::abs(value) < kMost && power > -kMostDecimals) {
    const double tens = std::pow(10.0, std::max(power, 0));
    const double whole = power > 0 ? std::round(value / tens) * tens : value;
    const std::string text = fmt::format("{:.{}f}", whole, std::max(-power, 0));
    const bool is_zero = text.find_first_of("123456789") == std::string::npos;
    return is_zero && text.front() == '-' ? text.substr(1) : text;
  }
  return fmt::format("{:.{}e}", value, std::max(0, first_power(value) - power));
}

}  // namespace

std::string rounded(double value, std::optional<double> error, int digits) {
  if (!std::isfinite(value) || !is_error(error)) return fmt::format("{:.{}g}", value, digits);
  return rounded_to(value, std::max(last_power(*error), first_power(value) - kMostDigits + 1));
}

std::string with_error(double value, std::optional<double> error, int digits) {
  if (!std::isfinite(value) || !is_error(error)) return rounded(value, error, digits);
  const int power = last_power(*error);
  const bool is_close = power >= first_power(value) - kMostDigits + 1;
  return rounded(value, error) + " +- " +
         (is_close ? rounded_to(*error, power) : fmt::format("{:.{}g}", *error, kErrorDigits));
}

}  // namespace samara
