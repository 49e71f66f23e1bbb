#include "samara/base/unit_labels.h"

#include <catch2/catch.hpp>

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
