#include "samara/models/checks/kinks.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/models/checks/check_model.h"
#include "samara/models/laws/registry.h"
#include "scalar_model.h"

using namespace samara::models;

namespace {

/// x' = f(x), with its derivative.
ScalarModel of_state(double (*f)(double), double (*slope)(double)) {
  return ScalarModel([f](double, double x, double) { return f(x); },
                     [slope](double, double x, double) { return slope(x); },
                     [](double, double, double) { return 0.0; });
}

/// x' = sqrt(x^2 + p^2)
ScalarModel with_floor() {
  return ScalarModel([](double, double x, double p) { return std::hypot(x, p); },
                     [](double, double x, double p) { return x / std::hypot(x, p); },
                     [](double, double x, double p) { return p / std::hypot(x, p); });
}

std::vector<Kink> of_floor(double floor) {
  return kinks_at_zero(with_floor(), {{0.0, {0.5}, {{floor}, {1}}}});
}

}  // namespace

TEST_CASE("what is smooth has no kink, |x| x neither: its second derivative jumps") {
  const auto sine =
      of_state([](double x) { return std::sin(3.0 * x); }, [](double x) { return 3.0 * std::cos(3.0 * x); });
  CHECK(find_kinks(sine).empty());
  const auto square =
      of_state([](double x) { return std::abs(x) * x; }, [](double x) { return 2.0 * std::abs(x); });
  CHECK(find_kinks(square).empty());
}

TEST_CASE("a kink of the slope is found at zero and off it, with its place and size") {
  const auto at_zero = of_state([](double x) { return std::abs(x); },
                                [](double x) { return static_cast<double>((x > 0.0) - (x < 0.0)); });
  const std::vector<Kink> first = find_kinks(at_zero);
  REQUIRE(first.size() == 1);
  CHECK_FALSE(first[0].is_of_rate);
  CHECK(first[0].distance == 0.0);
  // From -1 to 1, over the largest rate, that at 0.93 of the scale.
  CHECK(first[0].jump == Approx(2.0 / 0.93).epsilon(1e-3));
  const auto elsewhere = of_state([](double x) { return 2.0 + std::max(0.0, x - 0.37); },
                                  [](double x) { return x > 0.37 ? 1.0 : 0.0; });
  const std::vector<Kink> second = find_kinks(elsewhere);
  REQUIRE(second.size() == 1);
  CHECK(second[0].at == Approx(0.37).margin(1e-9));
}

TEST_CASE("a jump of the rate itself is told from one of its slope") {
  const auto step =
      of_state([](double x) { return 1.0 + (x > 0.21 ? 0.5 : 0.0); }, [](double) { return 0.0; });
  const std::vector<Kink> kinks = find_kinks(step);
  REQUIRE(kinks.size() == 1);
  CHECK(kinks[0].is_of_rate);
  CHECK(kinks[0].at == Approx(0.21).margin(1e-9));
  CHECK(kinks[0].jump == Approx(0.5 / 1.5).epsilon(1e-6));
}

TEST_CASE("a weight that hides a kink behind something smooth is not its floor") {
  // x' = p x^2 + sqrt(x^2 + c^2)
  for (const auto& [weight, c] : {std::pair(10.0, 4e-4), std::pair(10.0, 1.5e-3), std::pair(1.0, 3e-3)}) {
    const ScalarModel model([c](double, double x, double p) { return p * x * x + std::hypot(x, c); },
                            [c](double, double x, double p) { return 2.0 * p * x + x / std::hypot(x, c); },
                            [](double, double x, double) { return x * x; });
    CAPTURE(weight, c);
    for (const Kink& kink : kinks_at_zero(model, {{0.0, {0.5}, {{weight}, {1}}}})) CHECK(kink.floor.empty());
  }
}

TEST_CASE("the distance of a kink is that of its floor, which is named, and a wide floor is none") {
  for (const double floor : {1e-6, 1e-5, 1e-4, 1e-3}) {
    const std::vector<Kink> kinks = of_floor(floor);
    REQUIRE(kinks.size() == 1);
    // The slope changes by half from -0.58 to 0.58 of the floor; distances are told within a factor of two.
    CHECK(kinks[0].distance > 0.25 * floor);
    CHECK(kinks[0].distance < 2.0 * floor);
    CHECK(kinks[0].floor == "p");
  }
  CHECK(of_floor(0.05).empty());
}

TEST_CASE("the chord along the velocity of a card dips within its floor, and the law by default does not") {
  const auto card = find_model("immersed_body");
  const ModelInfo& info = card->info();
  ParameterValues p{std::vector<double>(info.parameters.size(), 0.0),
                    std::vector<char>(info.parameters.size(), 0)};
  const auto set = [&](const std::string& name, double value) {
    const auto j = static_cast<std::size_t>(std::ranges::find(info.parameters, name, &ParameterInfo::name) -
                                            info.parameters.begin());
    REQUIRE(j < p.value.size());
    p.value[j] = value;
    p.given[j] = 1;
  };
  set("a", 0.035);
  set("b", 0.02);
  set("c", 1e-4);
  set("density", 1200.0);
  std::vector<double> x(info.states.size(), 0.0);
  const auto state = [&](const std::string& name) -> double& {
    return x[static_cast<std::size_t>(std::ranges::find(info.states, name, &StateInfo::name) -
                                      info.states.begin())];
  };
  state("qw") = 1.0;
  state("uz") = -1.0;
  state("wx") = 5.0;
  state("wy") = 10.0;
  CHECK(kinks_at_zero(*card, {{0.0, x, p}}).empty());
  set("velocity_chord", 1.0);
  set("speed_floor", 1e-4);
  const std::vector<Kink> kinks = kinks_at_zero(*card, {{0.0, x, p}});
  const auto along = std::ranges::find(kinks, "ux", &Kink::state);
  REQUIRE(along != kinks.end());
  CHECK(along->is_of_rate);
  CHECK(along->term == "rotational lift");
  CHECK(along->floor == "speed_floor");
  CHECK(along->distance < 1e-3);
  // Beside the axis the other velocity is the floor, and the moment of the added mass is larger, but smooth.
  x[static_cast<std::size_t>(std::ranges::find(info.states, "uy", &StateInfo::name) - info.states.begin())] =
      0.003;
  const std::vector<Kink> beside = kinks_at_zero(*card, {{0.0, x, p}});
  const auto still = std::ranges::find(beside, "ux", &Kink::state);
  REQUIRE(still != beside.end());
  CHECK(still->term == "rotational lift");
  CHECK(still->floor.empty());
}

TEST_CASE("the check of a model notes its kinks, which are no findings") {
  const auto bend = of_state([](double x) { return std::abs(x); },
                             [](double x) { return static_cast<double>((x > 0.0) - (x < 0.0)); });
  const samara::Check check = check_model(bend);
  CHECK(check.passed());
  REQUIRE(check.notes.size() == 1);
  CHECK_THAT(check.notes[0], Catch::Contains("the rate of \"x\" bends at x = 0"));
}

TEST_CASE("a search for kinks refuses options without meaning") {
  CHECK_THROWS_WITH(find_kinks(with_floor(), {.points = 0}), "points is 0; 1 or more was expected");
}
