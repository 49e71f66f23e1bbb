#include "samara/codebooks/composition/motion_symmetry.h"

#include <numbers>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "samara/codebooks/build/build.h"
#include "samara/codebooks/composition/flow_map.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/interface/parametric_model.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;

namespace {

constexpr double kHalfTurn = std::numbers::pi;

/// A pendulum with air at its sides. `more` is added to what turns it, and to how fast its angle changes.
std::string pendulum(const std::string& more, const std::string& of_angle = "0",
                     const std::string& end = "0.2") {
  return fmt::format(R"toml([equations]
name = "pendulum"
states.angle = {{ initial = 0 }}
states.spin = {{ initial = 1 }}
parameters.pull = {{}}
rates.angle = "spin + {}"
rates.spin = "-0.1*abs(spin)*spin - pull*sin(angle) + {}"
[box]
pull = [0.8, 1.2]
"angle(0)" = [-3.14159265358979324, 3.14159265358979324]
"spin(0)" = [0.0, 3.0]
[time]
end = {}
[tolerance]
relative = 1e-5
)toml",
                     of_angle, more, end);
}

/// What is found of a plan, in its box.
MotionSymmetry found_in(const std::string& text,
                        samara::pgd::Transform transform = samara::pgd::Transform::none) {
  const Plan plan = parse_plan(text, "plan.toml");
  std::vector<DrawnInterval> box;
  for (const BoxEntry& entry : plan.box) box.push_back({entry.lower, entry.upper, transform});
  return motion_symmetry(plan.parametric_model(), box, 0.1);
}

std::vector<std::string> image_names(const MotionSymmetry& symmetry) {
  std::vector<std::string> names;
  for (const MotionImage& image : symmetry.images) names.push_back(image.name);
  return names;
}

}  // namespace

TEST_CASE("a pendulum has one reflection, that of its angle and its spin") {
  const MotionSymmetry symmetry = found_in(pendulum("0"));
  CHECK(image_names(symmetry) == std::vector<std::string>{"a reflection of angle, spin"});
  CHECK(symmetry.angles == std::vector<bool>{true, false});
  CHECK(symmetry.autonomous);
}

TEST_CASE("a law that acts for a part of the time is one that knows it") {
  CHECK_FALSE(found_in(pendulum("max(0.02 - abs(t - 0.05), 0)")).autonomous);
  CHECK_FALSE(found_in(pendulum("max(t - 0.11, 0)")).autonomous);
  // Long after the window, where motions go on window by window.
  CHECK_FALSE(found_in(pendulum("step(t - 30)")).autonomous);
}

TEST_CASE("laws that a reflection changes have none, wherever in the box and however little it does") {
  const std::string more =
      GENERATE(as<std::string>{}, "1e-7", "1e-6*cos(angle)", "1e-7*spin*spin",
               // In a corner: a twentieth of the angles, the fastest, the strongest pull.
               "(-50*max(angle - 2.8, 0))", "1e-3*max(spin - 2.85, 0)", "max(pull - 1.19, 0)",
               "max(angle - 2.8, 0)*max(pull - 1.18, 0)");
  INFO(more);
  CHECK(image_names(found_in(pendulum(more))).empty());
}

TEST_CASE("a wind that blows to one side takes the reflection away") {
  const auto in_wind = [](const std::string& wind) {
    return R"toml([equations]
name = "in_wind"
states.v = { initial = 1 }
parameters.wind = {}
rates.v = "-(v - wind)*abs(v - wind)"
)toml" + wind +
           R"toml(
"v(0)" = [-1, 1]
[time]
end = 0.2
[tolerance]
relative = 1e-5
)toml";
  };
  CHECK(image_names(found_in(in_wind("[fixed]\nwind = 0\n[box]"))) ==
        std::vector<std::string>{"a reflection of v"});
  CHECK(image_names(found_in(in_wind("[fixed]\nwind = 1e-6\n[box]"))).empty());
  // Calm air is in the box, and nothing but calm air has the reflection.
  CHECK(image_names(found_in(in_wind("[box]\nwind = [0, 0.1]"))).empty());
}

TEST_CASE("rates over ten decades do not hide a small one that a reflection changes") {
  const std::string text = R"toml([equations]
name = "stiff"
states.x = { initial = 1 }
parameters.k = {}
rates.x = "-k*x + 0.3"
[box]
k = [1, 1e10]
"x(0)" = [0.5, 1]
[time]
end = 0.2
[tolerance]
relative = 1e-5
)toml";
  CHECK(image_names(found_in(text)).empty());
  CHECK(image_names(found_in(text, samara::pgd::Transform::logarithm)).empty());
}

TEST_CASE(
    "half a turn and a reflection are found, and one after the other, each of which leaves the motion") {
  // Ends that are alike, and no side that is: angle by pi with u and v, and u alone of the reflections.
  const std::string text = R"toml([equations]
name = "rod"
states.angle = { initial = 0 }
states.spin = { initial = 1 }
states.u = {}
rates.angle = "spin"
rates.spin = "-0.5*spin - 0.3*sin(2*angle)"
rates.u = "-u + cos(angle)"
[box]
"angle(0)" = [-1, 1]
"spin(0)" = [-1, 1]
"u(0)" = [-1, 1]
[time]
end = 1
[tolerance]
relative = 1e-5
)toml";
  const MotionSymmetry symmetry = found_in(text);
  CHECK(image_names(symmetry) ==
        std::vector<std::string>{"a half turn of angle by pi", "a reflection of angle, spin",
                                 "a half turn of angle by pi and a reflection of angle, spin"});
  const samara::models::ParametricModel model = parse_plan(text, "plan.toml").parametric_model();
  const std::vector<double> times = {0.0, 0.3, 1.0, 4.0};
  const Eigen::Vector3d start(0.7, -0.4, 0.2);
  const auto run = [&](const Eigen::VectorXd& x) {
    return samara::models::integrate(model, {x.data(), 3}, times, {.relative_tolerance = 1e-11}).states;
  };
  const Eigen::MatrixXd states = run(start);
  for (const MotionImage& image : symmetry.images) {
    INFO(image.name);
    const Eigen::MatrixXd moved = run(image.of(start));
    for (Eigen::Index t = 0; t < 4; ++t)
      CHECK((image.back(moved.row(t).transpose()) - states.row(t).transpose()).norm() < 1e-8);
  }
  CHECK(symmetry.images[2].of(start).isApprox(Eigen::Vector3d(-0.7 - kHalfTurn, 0.4, -0.2)));
}

TEST_CASE("a flow map takes no image of a start at which the motion notices it") {
  // A law that acts in a ten-thousandth of the spins: the draws miss it, and the reflection stands in the list.
  const std::string text = pendulum("1e4*max(spin - 1.4999, 0)*max(1.5001 - spin, 0)");
  const Plan plan = parse_plan(text, "plan.toml");
  REQUIRE_FALSE(image_names(found_in(text)).empty());
  const Codebook book = build(plan, {.certificate_points = 20}).book;
  FlowMap flow_map(book);
  const std::vector<double> pull = {1.0}, times = {0.1};
  const FlowMapResult refused = flow_map.run(std::vector<double>{0.4, -1.5}, pull, times);
  CHECK(refused.status == FlowMapStatus::left_box);
  CHECK(refused.left == "spin");
  CHECK(flow_map.run(std::vector<double>{0.4, -1.6}, pull, times).status == FlowMapStatus::done);
}
