#include "samara/models/unit_warnings.h"

#include <catch2/catch.hpp>

using namespace samara::models;
using Catch::Matchers::Contains;

TEST_CASE("values that look like mistakes of units are named, plausible ones are not") {
  const auto card = find_model("immersed_body");
  CHECK(unit_warnings(*card,
                      {{"a", 0.035}, {"b", 0.02}, {"c", 1e-4}, {"density", 1200.0}, {"fluid_density", 1.2}})
            .empty());
  CHECK(unit_warnings(*card, {{"density", 2700.0}, {"fluid_density", 998.2}}).empty());
  CHECK(unit_warnings(*card, {}).empty());
  const auto solid = unit_warnings(*card, {{"density", 1.2}});
  REQUIRE(solid.size() == 1);
  CHECK_THAT(solid[0], Contains("1.2 kg/m^3") && Contains("1200 kg/m^3?"));
  CHECK_THAT(unit_warnings(*card, {{"fluid_density", 100.0}}).at(0), Contains("between those of gases"));
  CHECK_THAT(unit_warnings(*card, {{"fluid_density", 1e-3}}).at(0), Contains("water 998"));
  CHECK_THAT(unit_warnings(*card, {{"a", 35.0}}).at(0), Contains("a is 35 m"));
}

TEST_CASE("dimensionless models have no units to mistake") {
  CHECK(unit_warnings(*find_model("falling_plate_nd"), {{"inertia_ratio", 1.2}, {"A", 50.0}}).empty());
}
