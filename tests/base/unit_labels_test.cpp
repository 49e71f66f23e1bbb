#include "samara/base/unit_labels.h"

#include <limits>
#include <optional>

#include <catch2/catch.hpp>

#include "samara/base/rounded.h"

using samara::reads_as_unit;
using samara::unit_product;
using samara::unit_quotient;
using samara::unit_suffix;

TEST_CASE("units of labels multiply and divide as symbols do") {
  CHECK(unit_quotient("m/s", "s") == "m/s^2");
  CHECK(unit_product("m/s", "s") == "m");
  CHECK(unit_product("1", "kg") == "kg");
  CHECK(unit_quotient("1", "s") == "1/s");
  CHECK(unit_quotient("m", "m") == "1");
  CHECK(unit_product("kg m s^-1", "1/s") == "kg m/s^2");
  CHECK(unit_quotient("kg", "m s") == "kg m^-1 s^-1");
  CHECK(unit_quotient("W/(m K)", "s") == "W m^-1 K^-1 s^-1");
  CHECK(unit_product("W/(m K)", "1") == "W/(m K)");
}

TEST_CASE("symbols of labels need not be known") {
  CHECK(unit_quotient("EUR", "lb") == "EUR/lb");
  CHECK(unit_product("%", "\u03A9") == "% \u03A9");
}

TEST_CASE("a label that does not read as a unit stays as it is") {
  CHECK(unit_quotient("W/m K", "s") == "(W/m K)/(s)");
  CHECK(unit_product("s", "C_D") == "(s) (C_D)");
  CHECK(unit_product("as measured, in V", "1") == "as measured, in V");
}

TEST_CASE("a number without a unit is followed by nothing") {
  CHECK(unit_suffix("m/s") == " m/s");
  CHECK(unit_suffix("1").empty());
}

TEST_CASE("a unit is told from other texts, whether its symbols are known or not") {
  for (const char* unit : {"1", "kg/m^3", "1/s", "J/kg/K", "W/(m K)", "m^-1", "lb", "furlong/h"}) {
    INFO(unit);
    CHECK(reads_as_unit(unit));
  }
  for (const char* other : {"", "kg^x", "m^", "1/", "W/m K", "a_b", "2 m"}) {
    INFO(other);
    CHECK_FALSE(reads_as_unit(other));
  }
}

TEST_CASE("in a column of its own, the unit 1 is a dash") {
  CHECK(samara::shown_unit("1") == "-");
  CHECK(samara::shown_unit("m/s") == "m/s");
}

TEST_CASE("a value is shown to the second digit of its error") {
  using samara::rounded;
  using samara::with_error;
  CHECK(with_error(1.169173, 0.0953912) == "1.169 +- 0.095");
  CHECK(with_error(1.0, 0.12) == "1.00 +- 0.12");
  CHECK(with_error(1234.5, 130.0) == "1230 +- 130");
  CHECK(with_error(-0.004, 0.13) == "0.00 +- 0.13");
  CHECK(with_error(2.5, 0.0996) == "2.50 +- 0.10");  // an error that gains a digit when it is rounded
  CHECK(with_error(3.21e-9, 4.4e-11) == "3.210e-09 +- 4.4e-11");
  CHECK(with_error(3.21e8, 4.4e6) == "3.210e+08 +- 4.4e+06");
  CHECK(with_error(1.1999254141, 1.7e-11) == "1.19993 +- 1.7e-11");
  CHECK(rounded(17.3456, 8.4) == "17.3");
  CHECK(rounded(17.3456, 84.0) == "17");
}

TEST_CASE("a value without an error that counts has four digits") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::optional<double> error : {std::optional<double>(), {0.0}, {nan}}) {
    CHECK(samara::rounded(1.169173, error) == "1.169");
    CHECK(samara::with_error(1.169173, error) == "1.169");
  }
  CHECK(samara::rounded(nan, 0.1) == "nan");
}
