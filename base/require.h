#pragma once

#include <concepts>
#include <string_view>

/// Checks of numbers that a caller gives: one value each, so that a message names the one that is wrong.
namespace samara {

/// A number for a message; whole numbers of any size are shown as they are.
struct CheckedNumber {
  template <std::floating_point T>
  CheckedNumber(T number) : value(number) {}  // NOLINT(google-explicit-constructor)
  template <std::integral T>
  CheckedNumber(T number)  // NOLINT(google-explicit-constructor)
      : whole(static_cast<long long>(number)), is_whole(true) {}

  double value = 0.0;
  long long whole = 0;
  bool is_whole = false;
};

/// @param field name of the quantity or option, with its unit if it has one
/// @param expected what would be right: "at least 1"
/// @param where the function it was given to, or empty
/// @throws ArgumentError "where: field is value; expected was expected" unless it holds.
void require(bool holds, std::string_view field, CheckedNumber value, std::string_view expected,
             std::string_view where = {});

/// @throws ArgumentError, as above, if the value is not positive and finite.
void require_positive(double value, std::string_view field, std::string_view where = {});

/// @throws ArgumentError, as above, if the value is negative or not finite.
void require_not_negative(double value, std::string_view field, std::string_view where = {});

}  // namespace samara
