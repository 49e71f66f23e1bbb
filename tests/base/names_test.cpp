#include "samara/base/names.h"

#include <catch2/catch.hpp>

using samara::nearest_name;
using samara::suggestion;

namespace {
const std::vector<std::string> kNames = {"C_D", "m_a", "fluid_density", "thickness"};
}

TEST_CASE("the nearest name is the one with the fewest edits") {
  CHECK(nearest_name("C_d", kNames) == "C_D");
  CHECK(nearest_name("tickness", kNames) == "thickness");
  CHECK(nearest_name("fluid_densty", kNames) == "fluid_density");
}

TEST_CASE("no name is suggested when more than half differs") {
  CHECK(nearest_name("viscosity", kNames).empty());
  CHECK(suggestion("viscosity", kNames) == "; known: C_D, m_a, fluid_density, thickness");
}

TEST_CASE("a suggestion is a half sentence") {
  CHECK(suggestion("C_d", kNames) == "; did you mean \"C_D\"?");
  CHECK(suggestion("x", {}).empty());
}

TEST_CASE("control characters of one and of two bytes are shown as what they are") {
  CHECK(samara::printable("a\x1b[31m\n\x7f") == "a\\x1b[31m\\x0a\\x7f");
  CHECK(samara::printable("\xC2\x9B"
                          "2J") == "\\xc2\\x9b2J");
  CHECK(samara::printable("caf\xC3\xA9 \xC2\xB5m\nb", "\n") == "caf\xC3\xA9 \xC2\xB5m\nb");
  CHECK(samara::printable(std::string_view("\0", 1)) == "\\x00");
  CHECK(samara::printable("\xC2") == "\xC2");
}
