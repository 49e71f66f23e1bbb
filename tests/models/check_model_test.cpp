#include "samara/models/checks/check_model.h"

#include <algorithm>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "scalar_model.h"

using namespace samara::models;

namespace {

/// x' = p sin(x) + t, in order.
ScalarModel good_model() {
  return ScalarModel([](double t, double x, double p) { return p * std::sin(x) + t; },
                     [](double, double x, double p) { return p * std::cos(x); },
                     [](double, double x, double) { return std::sin(x); });
}

bool finds(const Model& model, const std::string& words) {
  const samara::Check check = check_model(model);
  return std::ranges::any_of(
      check.findings, [&](const std::string& finding) { return finding.find(words) != std::string::npos; });
}

}  // namespace

TEST_CASE("a model in order has no findings") {
  CHECK(check_model(good_model()).findings.empty());
}

TEST_CASE("wrong derivatives are found, even by a factor of one in a hundred thousand") {
  const ScalarModel by_state([](double, double x, double p) { return p * x; },
                             [](double, double, double p) { return 1.00001 * p; },
                             [](double, double x, double) { return x; });
  CHECK(finds(by_state, "derivative of the rate of \"x\" by \"x\""));
  const ScalarModel by_parameter([](double, double x, double p) { return p * x; },
                                 [](double, double, double p) { return p; },
                                 [](double, double x, double) { return 1.00001 * x; });
  CHECK(finds(by_parameter, "derivative of the rate of \"x\" by \"p\""));
}

TEST_CASE("a rate that is not a number is found") {
  const ScalarModel model([](double, double, double) { return std::nan(""); },
                          [](double, double, double) { return 0.0; },
                          [](double, double, double) { return 0.0; });
  CHECK(finds(model, "nan"));
}

TEST_CASE("missing texts, repeated names, odd units and impossible defaults are found") {
  ScalarModel model = good_model();
  ModelInfo& info = model.mutable_info();
  info.validity.clear();
  CHECK(finds(model, "no range of validity"));
  info.parameters[0].name = info.states[0].name;
  CHECK(finds(model, "\"x\" is used twice"));
  info.parameters[0].name = "x(0)";
  CHECK(finds(model, "\"x(0)\" is not made of letters"));
  info.parameters[0].unit.clear();
  CHECK(finds(model, "unit \"\""));
  info.parameters[0].unit = "kg m^2/s^2";
  CHECK_FALSE(finds(model, "does not read as a unit"));
  info.parameters[0].lower = 1.0;
  CHECK(finds(model, "outside its meaning"));
  info.parameters[0].default_value = std::nan("");
  CHECK(finds(model, "is not finite"));
}

TEST_CASE("a symmetry that does not hold is found") {
  ScalarModel model = good_model();
  model.mutable_info().symmetries = {"translation of x"};
  CHECK(finds(model, "f depends on \"x\""));
  model.mutable_info().symmetries = {"translation of z"};
  CHECK(finds(model, "names no state"));
  ScalarModel jump([](double, double x, double p) { return x < 0.5 ? 0.0 : p; },
                   [](double, double, double) { return 0.0; },
                   [](double, double x, double) { return x < 0.5 ? 0.0 : 1.0; });
  jump.mutable_info().symmetries = {"translation of x"};
  CHECK(finds(jump, "f depends on \"x\""));
}

TEST_CASE("a parameter with an upper bound alone is tried below it") {
  ScalarModel model([](double, double x, double p) { return -x * std::sqrt(1.1 - p); },
                    [](double, double, double p) { return -std::sqrt(1.1 - p); },
                    [](double, double x, double p) { return 0.5 * x / std::sqrt(1.1 - p); });
  model.mutable_info().parameters[0].upper = 1.0;
  CHECK(check_model(model).findings.empty());
}

TEST_CASE("the check refuses options without meaning") {
  CHECK_THROWS_WITH(check_model(good_model(), {.points = 0}), "points is 0; 1 or more was expected");
  CHECK_THROWS_AS(check_model(good_model(), {.tolerance = -1.0}), samara::ArgumentError);
}
