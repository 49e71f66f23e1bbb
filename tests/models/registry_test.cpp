#include <algorithm>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/models/checks/check_model.h"
#include "samara/models/interface/model.h"

using namespace samara::models;

TEST_CASE("the models that ship are listed in order and found by name") {
  const std::vector<std::string> names = model_names();
  CHECK(std::ranges::is_sorted(names));
  for (const std::string name :
       {"coefficient_body", "constant_rate", "immersed_body", "immersed_body_in_wind", "kirchhoff_body",
        "sphere_flight", "sphere_flight_turned_spin", "quadratic_drag_fall", "vertical_fall"}) {
    CHECK(std::ranges::count(names, name) == 1);
  }
  for (const std::string& name : names) CHECK(find_model(name)->info().name == name);
}

TEST_CASE("an unknown model names the nearest") {
  CHECK_THROWS_AS(find_model("vertical_fal"), samara::ArgumentError);
  CHECK_THROWS_WITH(find_model("vertical_fal"),
                    "there is no model \"vertical_fal\"; did you mean \"vertical_fall\"?");
}

TEST_CASE("every model that ships passes the check of models") {
  for (const std::string& name : model_names()) {
    INFO(name);
    const samara::Check check = check_model(*find_model(name), {.seed = 7, .points = 200});
    for (const std::string& finding : check.findings) FAIL_CHECK(finding);
  }
}

TEST_CASE("a state takes its scale by its unit") {
  const Scales scales = {.length = 2.0, .time = 4.0, .velocity = 8.0};
  const auto scale = [&](const char* unit) {
    return state_scale(StateInfo{.name = "s", .unit = unit}, scales);
  };
  CHECK(scale("m") == 2.0);
  CHECK(scale("m/s") == 8.0);
  CHECK(scale("rad/s") == 0.25);
  CHECK(scale("1/s") == 0.25);
  CHECK(scale("rad") == 1.0);
  CHECK(scale("1") == 1.0);
}
