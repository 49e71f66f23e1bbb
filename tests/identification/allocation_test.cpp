#include <catch2/catch.hpp>

#include "../allocation_counter.h"
#include "plate_captures.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"

using namespace samara::identification;

TEST_CASE("residuals of joined segments do not allocate, seen by a camera or not, by a late clock or not") {
  const std::map<std::string, double> held = {{"inertia_ratio", 1.4}, {"beta", 1.0 / 14.0}, {"B", 1.0}};
  std::map<std::string, double> values = held;
  values.insert({{"C_T", 1.2}, {"C_R", 3.14159}, {"A", 1.4}, {"mu1", 0.2}});
  const std::vector<double> times = plate_times(30, 20.0);
  const std::vector captures = {seen_plate(times, plate_states(values, times), 0.01, 1)};
  std::map<std::string, samara::models::Interval> box = {
      {"C_T", {0.3, 4.0}},    {"C_R", {1.0, 9.0}},    {"A", {0.4, 4.0}},     {"mu1", {0.1, 0.6}},
      {"vx(0)", {-8.0, 8.0}}, {"vy(0)", {-8.0, 8.0}}, {"w(0)", {-8.0, 8.0}}, {"theta(0)", {-60.0, 60.0}}};
  const auto family = step_trajectories(samara::models::find_model("falling_plate_nd"), held, box, 0.02);
  FitOptions options;
  options.loss.scales = {{"x", 0.01}, {"y", 0.01}, {"theta", 0.01}};
  options.segments.length = 1.0;
  for (const auto& [with_camera, with_clock] : {std::pair{false, false}, {true, false}, {true, true}}) {
    if (with_camera) options.camera = {.scale = 0.05, .rotation = 0.05, .angles = {{"theta"}}};
    if (with_clock) {
      options.measurement = {.delay = samara::models::Interval{-0.2, 0.3}, .gains = {{"theta", {0.05, 1.1}}}};
    }
    const FitProblem problem = make_problem(family->info(), captures, options);
    REQUIRE(problem.segments[0].joined);
    SegmentResidual residual(*family, problem, problem.segments[0]);
    const Eigen::Vector4d shared(1.3, 3.0, 1.2, 0.25);
    const Eigen::VectorXd own = Eigen::VectorXd::Constant(problem.own_count(), 0.1);
    REQUIRE(residual.evaluate(shared.data(), own.data(), own.data(), true));
    CHECK(allocation_counter::during(
              [&] { residual.evaluate(shared.data(), own.data(), own.data(), true); }) == 0);
  }
}
