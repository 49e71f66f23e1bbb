#include "samara/base/units.h"

#include <clocale>
#include <numbers>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "../error_text.h"

using Catch::Matchers::Contains;
using samara::ArgumentError;
using samara::difference_to_si;
using samara::Dimension;
using samara::is_coherent_si;
using samara::parse_unit;
using samara::quantity_to_si;
using samara::same_dimension;

namespace {
std::string unit_error(const std::string& text) {
  return error_text<ArgumentError>([&] { parse_unit(text); });
}
std::string quantity_error(const std::string& text, const std::string& unit) {
  return error_text<ArgumentError>([&] { quantity_to_si(text, unit); });
}
}  // namespace

TEST_CASE("units have their factors by definition") {
  const double pi = std::numbers::pi;
  // Powers of ten are exact; the others are correctly rounded up to one further operation.
  for (const auto& [text, factor] : std::vector<std::pair<std::string, double>>{
           {"m", 1},          {"mm", 1e-3},      {"kg", 1},       {"g", 1e-3},      {"mg", 1e-6},
           {"kg/m^3", 1},     {"g/cm^3", 1e3},   {"cm", 1e-2},    {"ms", 1e-3},     {"us", 1e-6},
           {"Hz", 1},         {"kHz", 1e3},      {"1/s", 1},      {"N", 1},         {"mN", 1e-3},
           {"Pa", 1},         {"hPa", 1e2},      {"mPa s", 1e-3}, {"J", 1},         {"W", 1},
           {"l", 1e-3},       {"ml", 1e-6},      {"min", 60},     {"h", 3600},      {"%", 1e-2},
           {"px", 1},         {"frame", 1},      {"cm/px", 1e-2}, {"K", 1},         {"1", 1},
           {"rad", 1},        {"deg", pi / 180}, {"rev", 2 * pi}, {"rpm", pi / 30}, {"bar", 1e5},
           {"kg m^2", 1},     {"mm^2/s", 1e-6},  {"dam", 10},     {"frame/s", 1},   {"rad/s", 1},
           {"\u00B5m", 1e-6}, {"\u03BCm", 1e-6}}) {
    INFO(text);
    CHECK(parse_unit(text).factor() == factor);
  }
  CHECK(parse_unit("km/h").factor() == Approx(1 / 3.6).epsilon(1e-15));
  CHECK(parse_unit("deg/s").factor() == Approx(pi / 180).epsilon(1e-15));
}

TEST_CASE("one unit may be written in many ways") {
  const Dimension acceleration = {.metre = 1, .second = -2};
  for (const char* text :
       {"m/s^2", "m s^-2", "m/s2", "m s-2", "m*s^-2", "m\u00B7s\u207B\u00B2", "m/s\u00B2", "m/s/s", "m/(s s)",
        " m / s^2 ", "m s**-2", "(m/s)/s", "s^-2 m", "m/(s^2)", "(m^-1 s^2)^-1", "N/kg"}) {
    INFO(text);
    CHECK(parse_unit(text).dimension == acceleration);
    CHECK(parse_unit(text).factor() == 1.0);
  }
}

TEST_CASE("a dimension is written as a unit that has it") {
  for (const char* text : {"kg m^-3", "m s^-1", "1", "px frame^-1", "kg m^2 s^-3 K^-1"}) {
    CHECK(to_string(parse_unit(text).dimension) == text);
  }
  CHECK(to_string(parse_unit("W/(m K)").dimension) == "kg m s^-3 K^-1");
}

TEST_CASE("dimensions multiply as exponents add") {
  CHECK(same_dimension("J", "N m"));
  CHECK(same_dimension("W", "J/s"));
  CHECK(same_dimension("Pa", "N/m^2"));
  CHECK(same_dimension("l", "m^3"));
  CHECK(same_dimension("rpm", "rad/s"));
  CHECK(same_dimension("W/m", "kg m/s^3"));
  CHECK(same_dimension("Pa s", "kg/(m s)"));
  CHECK(same_dimension("J/kg/K", "m^2 s^-2 K^-1"));
  CHECK_FALSE(same_dimension("A", "mol"));
  CHECK_FALSE(same_dimension("px", "m"));
  CHECK_FALSE(same_dimension("frame", "s"));
  CHECK_FALSE(same_dimension("kg", "N"));
}

TEST_CASE("coherent units of SI are told from scaled ones and from those of a camera") {
  for (const char* unit :
       {"1", "rad/s", "kg/m^3", "N m", "W/m", "1/s^2", "Pa s", "J/kg/K", "m^-1", "A", "mol", "cd"}) {
    INFO(unit);
    CHECK(is_coherent_si(unit));
  }
  for (const char* other : {"cm", "deg", "%", "min", "px", "m/frame", "lb", "ft", "kg^x", "", "m^", "1/"}) {
    INFO(other);
    CHECK_FALSE(is_coherent_si(other));
  }
}

TEST_CASE("a decimal in a scaled unit gives the double nearest to the product") {
  CHECK(quantity_to_si("1.5 mm", "m") == 1.5e-3);
  CHECK(quantity_to_si("2.7mm", "m") == 2.7e-3);
  CHECK(quantity_to_si("0.3 cm", "m") == 0.3e-2);
  CHECK(quantity_to_si("-4.9e2 um", "m") == -4.9e-4);
  CHECK(quantity_to_si("+0.7 g/cm^3", "kg/m^3") == 700.0);
  CHECK(quantity_to_si("5.1 1/s", "Hz") == 5.1);
}

TEST_CASE("a value converted to SI and back is the same to round-off") {
  for (const char* text : {"mm", "deg", "km/h", "rpm", "g/cm^3", "kPa", "%"}) {
    const samara::Unit unit = parse_unit(text);
    CHECK(unit.from_si(unit.to_si(1.7)) == Approx(1.7).epsilon(1e-15));
  }
}

TEST_CASE("angles and plain numbers stand for one another") {
  CHECK(quantity_to_si("180 deg", "rad") == Approx(std::numbers::pi).epsilon(1e-15));
  CHECK(quantity_to_si("90\u00B0", "rad") == Approx(std::numbers::pi / 2).epsilon(1e-15));
  CHECK(quantity_to_si("0.5", "rad") == 0.5);
  CHECK(quantity_to_si("0.5 rad", "1") == 0.5);
  CHECK(quantity_to_si("20 %", "1") == 0.2);
  CHECK(quantity_to_si("0.5", "deg") == 0.5);
}

TEST_CASE("inch, foot and pound are what they were agreed to be in 1959") {
  CHECK(quantity_to_si("1 in", "m") == 0.0254);
  CHECK(quantity_to_si("4 in/s", "m/s") == Approx(0.1016).epsilon(1e-15));
  CHECK(quantity_to_si("1 ft", "m") == Approx(0.3048).epsilon(1e-15));
  CHECK(quantity_to_si("12 in", "m") == Approx(quantity_to_si("1 ft", "m")).epsilon(1e-15));
  CHECK(quantity_to_si("1 lb", "kg") == 0.45359237);
  // As tables have it: water, 62.43 lb/ft^3.
  CHECK(quantity_to_si("62.43 lb/ft^3", "kg/m^3") == Approx(1000.0).epsilon(1e-4));
}

TEST_CASE("degrees Celsius have an offset, and stand for temperatures alone") {
  CHECK(quantity_to_si("20 degC", "K") == 293.15);
  CHECK(quantity_to_si("-273.15 \u00B0C", "K") == 0.0);
  CHECK(quantity_to_si("0degC", "mK") == 273.15);
  CHECK(difference_to_si("2 K", "K") == 2.0);
  CHECK_THAT(error_text<ArgumentError>([] { difference_to_si("2 degC", "K"); }),
             Contains("a difference of temperatures is given in K"));
  for (const char* product : {"W/(m degC)", "degC/s", "degC^2", "m degC"})
    CHECK_THAT(unit_error(product), Contains("stands alone after the number of a temperature"));
  CHECK_THAT(quantity_error("20 degC", "m"), Contains("has the dimension K, expected m"));
}

TEST_CASE("numbers have a decimal point whatever the locale") {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  if (std::setlocale(LC_ALL, "de_DE.UTF-8") == nullptr) std::setlocale(LC_ALL, "C.UTF-8");
  CHECK(quantity_to_si("1.5 mm", "m") == 1.5e-3);
  std::setlocale(LC_ALL, before.c_str());
}

TEST_CASE("a unit of another dimension is refused with both dimensions") {
  CHECK(quantity_error("1.5 mm", "kg/m^3") ==
        "\"1.5 mm\" has the dimension m, expected that of kg/m^3, kg m^-3");
  CHECK_THAT(quantity_error("3 px", "m"), Contains("px"));
  CHECK_THAT(quantity_error("3 1", "m"), Contains("dimension 1"));
}

TEST_CASE("an unknown unit is refused with the nearest known") {
  CHECK(unit_error("frames") == "unit \"frames\": unknown unit \"frames\"; did you mean \"frame\"?");
  CHECK_THAT(unit_error("KG/m^3"), Contains("unknown unit \"KG\"; did you mean \"kg\"?"));
  CHECK_THAT(unit_error("pA"), Contains("did you mean \"Pa\"?"));
  CHECK_THAT(unit_error("furlong"), Contains("known: m, s, g"));
  CHECK_THAT(quantity_error("2 mn", "m"), Contains("\"2 mn\": unknown unit \"mn\"; did you mean"));
  CHECK_THAT(unit_error("C"), Contains("did you mean \"degC\"?"));
  CHECK_THAT(unit_error("inches"), Contains("did you mean \"in\"?"));
  CHECK_THAT(unit_error("feet/s"), Contains("did you mean \"ft\"?"));
  CHECK_THAT(unit_error("kmin"), Contains("unknown unit"));
}

TEST_CASE("a malformed unit is refused") {
  CHECK_THAT(unit_error(""), Contains("empty"));
  CHECK_THAT(unit_error("m/"), Contains("ends where a symbol was expected"));
  CHECK_THAT(unit_error("/m"), Contains("expected a unit symbol"));
  CHECK_THAT(unit_error("m^"), Contains("not a whole number"));
  CHECK_THAT(unit_error("m^0.5"), Contains("not a whole number"));
  CHECK_THAT(unit_error("m^99"), Contains("beyond 12"));
  CHECK_THAT(unit_error("(m"), Contains("closing parenthesis"));
  CHECK_THAT(unit_error("m)"), Contains("unexpected \")\""));
  CHECK_THAT(unit_error("10 m"), Contains("expected a unit symbol"));
  CHECK_THAT(unit_error("W/m K"), Contains("ambiguous"));
  CHECK_THAT(unit_error("((((m^12)^12)^12)^12)^12"), Contains("beyond any use"));
  CHECK_THAT(unit_error(std::string(100000, '(')), Contains("longer than 200"));
}

TEST_CASE("an error stays one line of bounded length whatever the text") {
  CHECK_THAT(quantity_error("1 m\n\x1b", "m"), Contains("\"1 m\\x0a\\x1b\""));
  std::string omegas;
  for (int i = 0; i < 90; ++i) omegas += "\u03C9";
  CHECK_THAT(unit_error(omegas), Contains("...") && Contains("known: m, s"));
  CHECK(unit_error(omegas).size() < 400);
}

TEST_CASE("a malformed quantity is refused") {
  CHECK_THAT(quantity_error("mm", "m"), Contains("\"mm\": expected a number with a unit"));
  CHECK_THAT(quantity_error("", "m"), Contains("expected a number with a unit"));
  CHECK_THAT(quantity_error("1,5 mm", "m"), Contains("expected a number with a unit"));
  CHECK(quantity_error("soon", "1") == "\"soon\": expected a number, as in 1.5");
  CHECK_THAT(quantity_error("1.5.2 mm", "m"), Contains("expected a number with a unit"));
  CHECK_THAT(quantity_error("+-1 mm", "m"), Contains("expected a number with a unit"));
  CHECK_THAT(quantity_error("1.5", "m"), Contains("\"1.5\": the unit is missing, expected one like m"));
  CHECK_THAT(quantity_error("nan m", "m"), Contains("\"nan m\": expected a finite number"));
  CHECK_THAT(quantity_error("-inf m", "m"), Contains("expected a finite number"));
  CHECK_THAT(quantity_error("1e999 m", "m"), Contains("expected a finite number"));
  CHECK_THAT(quantity_error("1e308 km", "m"), Contains("too large"));
}
