#include "samara/models/checks/parameter_warnings.h"

#include <catch2/catch.hpp>

#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::Contains;

TEST_CASE("values that look like mistakes of units are named, plausible ones are not") {
  const auto card = find_model("immersed_body");
  CHECK(parameter_warnings(
            *card, {{"a", 0.035}, {"b", 0.02}, {"c", 1e-4}, {"density", 1200.0}, {"fluid_density", 1.2}})
            .empty());
  CHECK(parameter_warnings(*card, {{"density", 2700.0}, {"fluid_density", 998.2}}).empty());
  CHECK(parameter_warnings(*card, {}).empty());
  const auto solid = parameter_warnings(*card, {{"density", 1.2}});
  REQUIRE(solid.size() == 1);
  CHECK_THAT(solid[0], Contains("1.2 kg/m^3") && Contains("1200 kg/m^3?"));
  CHECK_THAT(parameter_warnings(*card, {{"fluid_density", 100.0}}).at(0), Contains("between those of gases"));
  CHECK_THAT(parameter_warnings(*card, {{"fluid_density", 1e-3}}).at(0), Contains("water 998"));
  CHECK_THAT(parameter_warnings(*card, {{"a", 35.0}}).at(0), Contains("a is 35 m"));
}

TEST_CASE("dimensionless models have no units to mistake") {
  CHECK(parameter_warnings(*find_model("falling_plate_nd"), {{"inertia_ratio", 1.2}, {"A", 50.0}}).empty());
}

TEST_CASE("moments of inertia that no body has are named, those of flat and round bodies are not") {
  const auto body = find_model("kirchhoff_body");
  const auto said = [&](std::map<std::string, double> values) {
    values.emplace("mass", 1.0);
    return parameter_warnings(*body, values);
  };
  const auto warnings = said({{"I_xx", 1.0}, {"I_yy", 1.0}, {"I_zz", 10.0}});
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("moments of inertia are 1, 1 and 10 kg m^2: no body has"));
  CHECK(said({{"I_xx", 1.0}, {"I_yy", 1.0}, {"I_zz", 2.0}}).empty());   // flat
  CHECK(said({{"I_xx", 1.0}, {"I_yy", 1.0}, {"I_zz", 1e-9}}).empty());  // a rod
  CHECK(said({{"I_xx", 1.0}, {"I_yy", 1.0}, {"I_zz", 1.0}}).empty());
  // Principal moments 0.1, 1 and 1.9: of axes that are turned.
  CHECK(said({{"I_xx", 1.0}, {"I_yy", 1.0}, {"I_zz", 1.0}, {"I_xy", 0.9}}).size() == 1);
  const auto card = find_model("immersed_body");
  const std::map<std::string, double> plate = {{"a", 0.035}, {"b", 0.02}, {"c", 1e-4}, {"density", 1200.0}};
  std::map<std::string, double> heavy = plate;
  heavy["I_z"] = 1e-3;  // beside I_x and I_y of 3e-8 and 9e-8, which follow from the axes
  CHECK(parameter_warnings(*card, plate).empty());
  CHECK(parameter_warnings(*card, heavy).size() == 1);
  CHECK_THAT(parameter_warnings(*find_model("sphere_flight"), {{"inertia", 1e-3}}).at(0),
             Contains("inertia is 0.001 kg m^2, more than 1.08e-06"));
}

TEST_CASE("plates thicker than they are wide are named") {
  const std::map<std::string, double> coin = {
      {"C_D", 1.2}, {"density", 6338.5}, {"area", 4.7144e-4}, {"thickness", 2.55e-3}};
  std::map<std::string, double> thick = coin;
  thick["thickness"] = 0.0245;
  const auto fall = find_model("vertical_fall");
  CHECK(parameter_warnings(*fall, coin).empty());
  REQUIRE(parameter_warnings(*fall, thick).size() == 1);
  CHECK_THAT(parameter_warnings(*fall, thick)[0],
             Contains("thickness is 0.0245 m, more than the radius of a disc of that area, 0.0122"));
  CHECK_THAT(parameter_warnings(*find_model("falling_plate"),
                                {{"semi_chord", 1e-3}, {"semi_thickness", 0.01}, {"density", 2700.0}})
                 .at(0),
             Contains("more than semi_chord, 0.001 m: were the two mixed up?"));
  CHECK_THAT(parameter_warnings(*find_model("falling_rectangle"),
                                {{"chord", 1e-3}, {"thickness", 0.01}, {"density", 2700.0}})
                 .at(0),
             Contains("more than the chord"));
  CHECK_THAT(parameter_warnings(*find_model("immersed_body"),
                                {{"a", 0.03}, {"b", 0.02}, {"c", 0.025}, {"density", 1200.0}})
                 .at(0),
             Contains("c is 0.025 m, more than b"));
}

TEST_CASE("parameters that are missing or outside their meaning are left to those who refuse them") {
  const auto fall = find_model("vertical_fall");
  CHECK(parameter_warnings(*fall, {{"thickness", 1.0}}).empty());
  CHECK(parameter_warnings(*fall, {{"C_D", 1.2}, {"density", 6338.5}, {"area", -1.0}, {"thickness", 1.0}})
            .empty());
  CHECK(parameter_warnings(*find_model("immersed_body"),
                           {{"a", 0.0}, {"b", 1.0}, {"c", 2.0}, {"density", 1200.0}})
            .empty());
}
