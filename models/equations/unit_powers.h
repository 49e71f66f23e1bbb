#pragma once

#include <array>
#include <optional>
#include <string>

#include <boost/rational.hpp>

#include "samara/base/units.h"

/// Internal to models/.
namespace samara::models {

/// What an expression is measured in: powers of the base units, as fractions, since square roots halve them.
class UnitPowers {
 public:
  using Power = boost::rational<int>;

  UnitPowers() = default;
  explicit UnitPowers(const Dimension& dimension);

  /// @throws ArgumentError where a power would be beyond all use
  UnitPowers times(const UnitPowers& other, int sign = 1) const;
  /// @returns nothing where a power would be beyond all use
  std::optional<UnitPowers> raised(Power exponent) const;
  bool is_dimensionless() const { return *this == UnitPowers(); }
  bool operator==(const UnitPowers&) const = default;

 private:
  friend std::string to_string(const UnitPowers& powers);
  std::array<Power, 9> powers_ = {};
};

/// "m s^-1", "m^1/2"; "1" if dimensionless.
std::string to_string(const UnitPowers& powers);

/// The fraction with a small denominator that a number is; none: nothing.
std::optional<UnitPowers::Power> fraction_of(double number);

}  // namespace samara::models
