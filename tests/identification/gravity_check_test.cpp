#include "samara/identification/captures/gravity_check.h"

#include <catch2/catch.hpp>

#include "files.h"
#include "samara/models/equations/equation_model.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"
#include "synthetic.h"

using namespace samara::identification;

namespace {

using samara::models::ParametricModel;

/// A ball thrown up and forward, or a plate that falls and flutters, with its places measured.
std::vector<Capture> motions(const ParametricModel& model, const std::vector<double>& times, double up) {
  const auto trajectory = samara::models::integrate(model, {}, times);
  Capture capture = make_capture("a", times, trajectory.states.col(0));
  capture.channels[0].quantity = model.model().info().states[0].name;
  for (std::size_t k = 1; k < model.model().info().states.size(); ++k) {
    const auto& state = model.model().info().states[k];
    if (state.unit != "m") continue;
    const double sign = state.name == "z" || state.name == "y" ? up : 1.0;
    capture.channels.push_back({state.name, "m", sign * trajectory.states.col(static_cast<Eigen::Index>(k))});
  }
  return {capture};
}

std::vector<std::string> doubts(const std::string& name, const std::map<std::string, double>& values,
                                const std::vector<double>& times, double up) {
  const ParametricModel model(samara::models::find_model(name), values, {});
  std::vector<Capture> captures = motions(model, times, up);
  std::erase_if(captures[0].channels, [](const Channel& c) { return c.unit != "m"; });
  return check_gravity(model, {}, captures);
}

}  // namespace

TEST_CASE("a flight upside down is suspected, and one that rises for a while is not") {
  const std::map<std::string, double> ball = {{"C_D", 0.5}, {"vx(0)", 3.0}, {"vz(0)", 4.0}};
  const std::vector<double> times = even_times(61, 0.8);
  CHECK(doubts("sphere_flight", ball, times, 1.0).empty());
  const auto found = doubts("sphere_flight", ball, times, -1.0);
  REQUIRE(found.size() == 1);
  CHECK_THAT(found[0],
             Catch::StartsWith("capture \"a\": it moves against the weight of the model, which acts "
                               "along -z") &&
                 Catch::EndsWith("is an axis upside down? (flip = [\"z\"] in a sidecar turns it)"));
}

TEST_CASE("a fall at its final speed is suspected where it goes up, whatever the axis is called") {
  const std::map<std::string, double> coin = {
      {"C_D", 1.2}, {"area", 4.7e-4}, {"thickness", 2.5e-3}, {"density", 6338.0}};
  const ParametricModel model(samara::models::find_model("vertical_fall"), coin, {});
  const std::vector<double> times = even_times(41, 1.5);
  std::vector<Capture> captures = {
      make_capture("down", times, 0.4 * Eigen::VectorXd::LinSpaced(41, 0.0, 1.5)),
      make_capture("up", times, -0.4 * Eigen::VectorXd::LinSpaced(41, 0.0, 1.5))};
  const auto found = check_gravity(model, {}, captures);
  REQUIRE(found.size() == 1);
  CHECK_THAT(found[0], Catch::Contains("\"up\"") && Catch::Contains("along +x"));
}

TEST_CASE("a plate that flutters and tumbles is not suspected, and upside down it is") {
  const std::map<std::string, double> plate = {{"semi_chord", 0.02},
                                               {"semi_thickness", 33.6e-6},
                                               {"density", 1000.0},
                                               {"fluid_density", 1.2},
                                               {"theta(0)", 0.4}};
  const std::vector<double> times = even_times(121, 1.2);
  CHECK(doubts("falling_plate", plate, times, 1.0).empty());
  CHECK(doubts("falling_plate", plate, times, -1.0).size() == 1);
  // A mirrored film mirrors the angle as well, which the advice names where it is measured.
  const ParametricModel model(samara::models::find_model("falling_plate"), plate, {});
  std::vector<Capture> mirrored = motions(model, times, -1.0);
  std::erase_if(mirrored[0].channels, [](const Channel& c) { return c.unit != "m"; });
  mirrored[0].channels.push_back({"theta", "rad", Eigen::VectorXd::Zero(121)});
  CHECK_THAT(check_gravity(model, {}, mirrored).at(0),
             Catch::Contains("(flip = [\"y\", \"theta\"] in a sidecar"));
}

TEST_CASE("a spring or a drive that pulls at the place 0 is no weight, and a steady pull is") {
  const auto pulled = [](const std::string& acceleration) {
    return samara::models::equation_model(
        {.name = "pulled",
         .states = {{.name = "x", .unit = "m"}, {.name = "v", .unit = "m/s"}},
         .parameters = {{.name = "k", .unit = "1/s^2"},
                        {.name = "w", .unit = "1/s"},
                        {.name = "L", .unit = "m"}},
         .rates = {"v", acceleration}});
  };
  // Of steady speed against what pulls at rest at 0, which is 3 m/s^2 in all three.
  const std::vector<double> times = even_times(41, 1.0);
  const std::vector<Capture> captures = {make_capture("a", times, -Eigen::VectorXd::LinSpaced(41, 0.0, 1.0))};
  const std::map<std::string, double> values = {{"k", 10.0}, {"w", 3.0}, {"L", 0.3}};
  const auto found = [&](const std::string& acceleration) {
    return check_gravity(ParametricModel(pulled(acceleration), values, {}), {}, captures).size();
  };
  CHECK(found("k*(L - x)") == 0);
  CHECK(found("k*L*cos(w*t)") == 0);
  CHECK(found("k*L") == 1);
}

TEST_CASE("what a sidecar has turned the wrong way is to be left out of it, or said the other way round") {
  const TemporaryDirectory files;
  const auto doubt = [&](const ParametricModel& model, const std::string& header, const std::string& rest,
                         const std::string& sidecar) {
    std::string rows = header + "\n";
    for (int k = 0; k < 20; ++k) rows += fmt::format("{},{}{}\n", 0.02 * k, 0.01 * k, rest);
    files.put("fall.csv", rows);
    files.put("fall.toml", sidecar);
    return check_gravity(model, {}, read_captures(files.path() / "fall.csv")).at(0);
  };
  // Steady motions. Down is +x of a vertical fall, which the file had right.
  const ParametricModel coin(samara::models::find_model("vertical_fall"),
                             {{"C_D", 1.2}, {"area", 4.7e-4}, {"thickness", 2.5e-3}, {"density", 6338.0}},
                             {});
  CHECK_THAT(doubt(coin, "t[s],x[m]", "", "flip = [\"x\"]\n"),
             Catch::EndsWith("(flip = [\"x\"] of its sidecar turned it: leave that out)"));
  // Down is -z of a flight; y, which the sidecar takes to point up, grows.
  const ParametricModel ball(samara::models::find_model("sphere_flight"),
                             {{"C_D", 0.5}, {"vx(0)", 3.0}, {"vz(0)", 4.0}}, {});
  CHECK_THAT(doubt(ball, "t[s],y[m],x[m],z[m],qw[1],qx[1],qy[1],qz[1]", ",0,0,1,0,0,0", "up = \"y\"\n"),
             Catch::EndsWith("(up = \"-y\" in its sidecar turns it)"));
}
