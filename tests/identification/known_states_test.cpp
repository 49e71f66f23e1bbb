#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/identification/fit/fit.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::WithinRel;

namespace {

/// A flight of a ball with topspin, its spin in a label.
Capture ball_flight(const std::string& id, double speed, double spin) {
  const samara::models::ParametricModel model(
      samara::models::find_model("sphere_flight"),
      {{"C_D", 0.5}, {"C_M", 0.8}, {"vx(0)", speed}, {"vz(0)", 1.0}, {"wy(0)", spin}}, {});
  const std::vector<double> times = even_times(31, 0.2);
  const auto trajectory = samara::models::integrate(model, {}, times);
  Capture capture = make_capture(id, times, trajectory.states.col(0));
  capture.channels.push_back({"y", "m", trajectory.states.col(1)});
  capture.channels.push_back({"z", "m", trajectory.states.col(2)});
  capture.labels["spin"] = fmt::format("{}", spin);
  return capture;
}

}  // namespace

TEST_CASE("captures in one piece start from where they are seen to start, also with states that are known") {
  // Frames are exact to the tolerance of the integrator and the steps of 7 ms, 1e-8 m: C_D and C_M show in
  // centimetres.
  std::map<std::string, samara::models::Interval> box = {
      {"C_D", {0.1, 1.5}}, {"C_M", {0.1, 2.0}}, {"wy(0)", {-500.0, 500.0}}};
  for (const char* name : {"x(0)", "y(0)", "z(0)"}) box[name] = {-5.0, 5.0};
  for (const char* name : {"vx(0)", "vy(0)", "vz(0)"}) box[name] = {-30.0, 30.0};
  const auto family = step_trajectories(samara::models::find_model("sphere_flight"), {}, box, 7e-3);
  const std::vector<Capture> captures = {ball_flight("a", 6.0, 150.0), ball_flight("b", -8.0, 60.0)};
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.unknowns.known["wy(0)"] = "spin";
  options.starts.count = 1;
  options.segments.length = 10.0;
  const FitResult result = fit(*family, captures, options);
  REQUIRE(result.is_usable());
  CHECK_THAT(result.coefficients[0].value, WithinRel(0.5, 1e-5));
  CHECK_THAT(result.coefficients[1].value, WithinRel(0.8, 1e-5));

  // Cut, they would have to end where the next begins, which what is known for the whole capture cannot.
  options.segments.length = 0.05;
  CHECK_THROWS_AS(fit(*family, captures, options), samara::ArgumentError);
}
