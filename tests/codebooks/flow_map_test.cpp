#include "samara/codebooks/composition/flow_map.h"

#include <cmath>
#include <random>
#include <span>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/query/query.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;

namespace {

Codebook built(const std::string& box, const std::string& end, const std::string& model = "vertical_fall",
               const std::string& fixed = "density = 6339\narea = 4.714e-4\nthickness = '2.55 mm'\n") {
  const std::string plan = "model = '" + model + "'\n[fixed]\n" + fixed + "[box]\n" + box +
                           "[time]\nend = " + end + "\n[tolerance]\nrelative = 1e-5\n";
  return build(parse_plan(plan, "plan.toml"), {.certificate_points = 50}).book;
}

/// The flow map of a falling coin over 50 ms; depth x is only displaced.
const Codebook& coin_window() {
  static const Codebook book = built("C_D = [0.8, 1.6]\n'v(0)' = [0.0, 1.0]\n", "0.05");
  return book;
}

samara::models::ParametricModel fall_of(const std::vector<std::string>& free) {
  return {samara::models::find_model("vertical_fall"),
          {{"density", 6339.0}, {"area", 4.714e-4}, {"thickness", 2.55e-3}},
          free};
}

std::vector<double> steps(double end, int count) {
  std::vector<double> times;
  for (int i = 0; i <= count; ++i) times.push_back(end * i / count);
  return times;
}

}  // namespace

TEST_CASE("a flow map of windows follows the integrator far beyond the codebook's time") {
  FlowMap flow_map(coin_window());
  CHECK(flow_map.window() == 0.05);
  CHECK(flow_map.states() == std::vector<std::string>{"v", "x"});
  REQUIRE(flow_map.parameters().size() == 1);
  CHECK(flow_map.parameters()[0].name == "C_D");
  const samara::models::ParametricModel model = fall_of({"C_D", "v(0)", "x(0)"});
  const std::vector<double> times = steps(1.0, 77);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform;
  for (int i = 0; i < 20; ++i) {
    const std::vector<double> q = {0.8 + 0.8 * uniform(random), 0.5 * uniform(random),
                                   10.0 * uniform(random)};
    const FlowMapResult result =
        flow_map.run(std::vector<double>{q[1], q[2]}, std::vector<double>{q[0]}, times);
    REQUIRE(result.status == FlowMapStatus::done);
    CHECK(result.reached == 1.0);
    const samara::models::Trajectory exact = samara::models::integrate(model, q, times);
    // Each of the 20 windows is good to 1e-5 of its range, about 1 m/s and 0.05 m. Drag makes errors of v
    // decay within few windows; those of x add up to at most 20 windows' and what v brings.
    CHECK((result.states.col(0) - exact.states.col(0)).cwiseAbs().maxCoeff() < 5e-5);
    CHECK((result.states.col(1) - exact.states.col(1)).cwiseAbs().maxCoeff() < 5e-5);
  }
}

TEST_CASE("composed derivatives of a flow map are the integrator's sensitivities") {
  FlowMap flow_map(coin_window());
  const samara::models::ParametricModel model = fall_of({"v(0)", "x(0)", "C_D"});
  const std::vector<double> times = {0.0, 0.02, 0.05, 0.1, 0.33, 0.9};
  const std::vector<double> q = {0.1, 3.0, 1.1};
  const FlowMapResult result =
      flow_map.run(std::vector<double>{q[0], q[1]}, std::vector<double>{q[2]}, times, true);
  const samara::models::Trajectory exact = samara::models::integrate(model, q, times, {}, true);
  REQUIRE(result.derivatives.size() == times.size());
  for (std::size_t t = 0; t < times.size(); ++t) {
    for (std::size_t j = 0; j < 3; ++j) {
      const Eigen::VectorXd column = result.derivatives[t].col(static_cast<Eigen::Index>(j));
      const Eigen::VectorXd sensitivity =
          exact.sensitivities[j].row(static_cast<Eigen::Index>(t)).transpose();
      // A codebook to 1e-5 has derivatives to about 1e-3 of their size.
      CHECK((column - sensitivity).norm() < 1e-3 * (1.0 + sensitivity.norm()));
    }
  }
  CHECK(result.derivatives[0].leftCols(2).isIdentity(1e-4));
}

TEST_CASE("inside the first window a flow map is the codebook") {
  FlowMap flow_map(coin_window());
  Query query(coin_window());
  Eigen::VectorXd values(2);
  for (const double t : {0.0, 0.013, 0.05}) {
    query.values(std::vector<double>{t, 1.2, 0.25}, values);
    const FlowMapResult result =
        flow_map.run(std::vector<double>{0.25, 0.0}, std::vector<double>{1.2}, std::vector<double>{t});
    CHECK(result.states(0, 0) == values[0]);
    CHECK(result.states(0, 1) == values[1]);
  }
}

TEST_CASE("a state that leaves the box stops the flow map with its name and the time") {
  // The coin passes 0.3 m/s, where the axis of v(0) ends, before the window of 0.5 s does.
  FlowMap flow_map(coin_build().book);
  const std::vector<double> times = {0.1, 0.5, 0.50001, 0.7};
  const FlowMapResult result =
      flow_map.run(std::vector<double>{0.0, 0.0}, std::vector<double>{1.0}, times, true);
  CHECK(result.status == FlowMapStatus::left_box);
  CHECK(result.left == "v");
  CHECK(result.reached == 0.5);
  CHECK_THAT(result.message, Contains("t = 0.5:") && Contains("v = ") && Contains("outside [0, 0.3]"));
  CHECK(result.states.topRows(2).allFinite());
  CHECK(result.states.bottomRows(2).array().isNaN().all());
  CHECK(result.derivatives[2].array().isNaN().all());
  // Started outside, it does not begin.
  const FlowMapResult outside = flow_map.run(std::vector<double>{0.4, 0.0}, std::vector<double>{1.0}, times);
  CHECK(outside.status == FlowMapStatus::left_box);
  CHECK(outside.reached == 0.0);
}

TEST_CASE("codebooks that have no flow map, and calls that make no sense, are refused by name") {
  const Codebook no_axis = built("C_D = [0.8, 1.6]\n", "0.05");
  CHECK_THROWS_WITH(FlowMap(no_axis), Contains("needs an axis \"v(0)\"") && Contains("vertical_fall"));
  FlowMap flow_map(coin_window());
  const std::vector<double> start = {0.1, 0.0}, C_D = {1.0}, times = {0.1};
  CHECK_THROWS_WITH(flow_map.run(C_D, C_D, times), Contains("2 states and 1 parameters was given 1 and 1"));
  CHECK_THROWS_WITH(flow_map.run(std::vector<double>{std::nan(""), 0.0}, C_D, times),
                    Contains("v(0) is nan"));
  CHECK_THROWS_WITH(flow_map.run(start, C_D, std::vector<double>{0.2, 0.1}), Contains("0.1 after 0.2"));
  CHECK_THROWS_WITH(flow_map.run(start, C_D, std::vector<double>{-0.1}), Contains("-0.1 after 0"));
  CHECK_THROWS_WITH(flow_map.run(start, C_D, std::vector<double>{1e18}), Contains("at most 1e+07 windows"));
  CHECK_THROWS_AS(flow_map.run(start, std::vector<double>{3.0}, times), samara::OutsideBoxError);
}

namespace {

/// The flow map of a plate over a tenth of a time unit, all attitudes; x and y are only displaced.
const BuildResult& plate_window() {
  static const BuildResult result = build(parse_plan(R"toml(model = "falling_plate_nd"
[box]
"w(0)" = [-2.5, 0.5]
"theta(0)" = [-3.14159265358979324, 3.14159265358979324]
"vx(0)" = [0.3, 2.0]
"vy(0)" = [-1.2, -0.2]
[time]
end = 0.1
[tolerance]
relative = 1e-4
[builder]
kind = "sampling"
)toml",
                                                     "window.toml"),
                                          {.certificate_points = 100});
  return result;
}

}  // namespace

TEST_CASE("a flow map of windows of trains carries a tumbling plate over full turns, with derivatives") {
  INFO(plate_window().message);
  REQUIRE(plate_window().met);
  const Codebook& book = plate_window().book;
  REQUIRE(book.pieces()[0].groups()[0].train() != nullptr);
  FlowMap flow_map(book);
  CHECK(flow_map.states() == std::vector<std::string>{"vx", "vy", "w", "theta", "x", "y"});
  // Two turns below the box: the angle is wrapped at the first window, and again where it leaves the box.
  const std::vector<double> start = {1.0, -0.6, -1.5, -4.0 * 3.14159265358979 - 3.1, 5.0, -7.0};
  const std::vector<double> times = steps(0.4, 8);
  const FlowMapResult result = flow_map.run(start, {}, times, true);
  INFO(result.message);
  REQUIRE(result.status == FlowMapStatus::done);
  const samara::models::ParametricModel model(samara::models::find_model("falling_plate_nd"), {},
                                              {"vx(0)", "vy(0)", "w(0)", "theta(0)", "x(0)", "y(0)"});
  const samara::models::Trajectory exact = samara::models::integrate(model, start, times, {}, true);
  CHECK(exact.states(8, 3) < start[3] - 0.1);  // it goes on turning downward, through -pi of the box
  // Four windows, each good to 1e-4 of ranges up to 6; what is carried grows by less than e^(0.4 * 3).
  CHECK((result.states - exact.states).cwiseAbs().maxCoeff() < 4 * 6e-4 * 3.3);
  for (std::size_t k = 0; k < start.size(); ++k) {
    // Slopes of errors of 1e-4 in polynomials of degree 10 or so.
    const Eigen::VectorXd slopes = result.derivatives[8].col(static_cast<Eigen::Index>(k));
    CHECK((slopes - exact.sensitivities[k].row(8).transpose()).cwiseAbs().maxCoeff() < 0.05);
  }
}

TEST_CASE("a flow map of trains that leaves its box says when and which state") {
  FlowMap flow_map(plate_window().book);
  const std::vector<double> start = {1.9, -0.3, -0.5, -2.0, 0.0, 0.0};
  const FlowMapResult result = flow_map.run(start, {}, steps(10.0, 100));
  CHECK(result.status == FlowMapStatus::left_box);
  CHECK_FALSE(result.left.empty());
  CHECK(result.reached < 10.0);
  CHECK_THAT(result.message, Contains("the flow map left the box at t = ") && Contains(result.left + " = "));
  CHECK(std::isnan(result.states(100, 0)));
}

namespace {

/// A body that is the same after half a turn, in its own axes: u and v change sign with it. Its weight turns with a
/// share of its length, `lever`: with a lever the two ends are not alike.
std::string spinning_thing(double lever) {
  return R"toml([equations]
name = "spinning_thing"
states.angle = { initial = 0 }
states.spin = { initial = 1 }
states.u = {}
states.v = {}
parameters.pull = {}
rates.angle = "spin"
rates.spin = "1 - 0.5*spin - 0.3*sin(2*angle) - 0.4*u*v - )toml" +
         std::to_string(lever) + R"toml(*cos(angle)"
rates.u = "spin*v - u + pull*cos(angle)"
rates.v = "-spin*u - 2*v - pull*sin(angle)"
[box]
pull = [0.8, 1.2]
"angle(0)" = [-1.5707963267948966, 1.5707963267948966]
"spin(0)" = [0.5, 2.5]
"u(0)" = [-1.2, 1.2]
"v(0)" = [-1.2, 1.2]
[time]
end = 0.2
[tolerance]
relative = 1e-5
)toml";
}

BuildResult spinning_window(double lever) {
  return build(parse_plan(spinning_thing(lever), "spinning.toml"), {.certificate_points = 100});
}

}  // namespace

TEST_CASE("half a turn of an angle carries a body that is the same after half a turn over full ones") {
  const BuildResult window = spinning_window(0.0);
  INFO(window.message);
  REQUIRE(window.met);
  FlowMap flow_map(window.book);
  const samara::models::ParametricModel model(model_of(window.book).shared_model(), {},
                                              {"angle(0)", "spin(0)", "u(0)", "v(0)", "pull"});
  const std::vector<double> times = steps(10.0, 43);
  for (const double angle : {0.3, 1.5707963267948966, 2.0, -8.0}) {
    const std::vector<double> q = {angle, 1.1, 0.4, -0.2, 0.93};
    const FlowMapResult result = flow_map.run(std::span(q).first(4), std::span(q).last(1), times, true);
    INFO(result.message);
    REQUIRE(result.status == FlowMapStatus::done);
    const samara::models::Trajectory exact = samara::models::integrate(model, q, times, {}, true);
    CHECK(exact.states(43, 0) > angle + 12.0);  // almost two turns
    // Fifty windows of 1e-5 of ranges up to 3; spin, u and v are damped, and the angle sums what errors leave.
    CHECK((result.states - exact.states).cwiseAbs().maxCoeff() < 50 * 3e-5);
    for (std::size_t k = 0; k < q.size(); ++k) {
      const Eigen::VectorXd slopes = result.derivatives[43].col(static_cast<Eigen::Index>(k));
      CHECK((slopes - exact.sensitivities[k].row(43).transpose()).cwiseAbs().maxCoeff() < 0.02);
    }
  }
}

TEST_CASE("half of a box carries a motion whose mirror image moves as it does, with derivatives") {
  // A damped pendulum: angle and spin change sign together. The box holds one sign of the spin.
  const BuildResult window = build(parse_plan(R"toml([equations]
name = "damped_pendulum"
states.angle = { initial = 0 }
states.spin = { initial = 1 }
parameters.pull = {}
rates.angle = "spin"
rates.spin = "-0.1*abs(spin)*spin - pull*sin(angle)"
[box]
pull = [0.8, 1.2]
"angle(0)" = [-3.14159265358979324, 3.14159265358979324]
"spin(0)" = [0.0, 3.0]
[time]
end = 0.2
[tolerance]
relative = 1e-6
)toml",
                                              "pendulum.toml"),
                                   {.certificate_points = 100});
  INFO(window.message);
  REQUIRE(window.met);
  FlowMap flow_map(window.book);
  const samara::models::ParametricModel model(model_of(window.book).shared_model(), {},
                                              {"angle(0)", "spin(0)", "pull"});
  const std::vector<double> times = steps(8.0, 33);
  for (const double spin : {-0.7, 2.6}) {  // to and fro, and first over the top
    const std::vector<double> q = {0.4, spin, 0.93};
    const FlowMapResult result = flow_map.run(std::span(q).first(2), std::span(q).last(1), times, true);
    INFO(result.message);
    REQUIRE(result.status == FlowMapStatus::done);
    const samara::models::Trajectory exact = samara::models::integrate(model, q, times);
    CHECK(exact.states.col(1).minCoeff() < -0.3);
    // Forty windows of 1e-6 of ranges up to 6, which grow near the top, by less than e^3.
    CHECK((result.states - exact.states).cwiseAbs().maxCoeff() < 40 * 6e-6 * 20);
    // Derivatives are those of what the flow map answers, to what central differences leave: h^2 / 6 of
    // third derivatives, which grow at most as the cube of e^3, 1.3e-7, and last digits of numbers up to 10
    // over h, which grow by e^3 as well, 4e-9.
    constexpr double kStep = 1e-5;
    for (std::size_t k = 0; k < q.size(); ++k) {
      const auto end_of = [&](double by) -> Eigen::VectorXd {
        std::vector<double> moved = q;
        moved[k] += by;
        return flow_map.run(std::span(moved).first(2), std::span(moved).last(1), times).states.row(33);
      };
      const Eigen::VectorXd slopes = result.derivatives[33].col(static_cast<Eigen::Index>(k));
      const Eigen::VectorXd differences = (end_of(kStep) - end_of(-kStep)) / (2.0 * kStep);
      CHECK((slopes - differences).cwiseAbs().maxCoeff() < 2e-7);
    }
  }
}

TEST_CASE("a body that notices a half turn leaves the box there, and it is said when") {
  const BuildResult window = spinning_window(0.05);
  REQUIRE(window.met);
  FlowMap flow_map(window.book);
  const std::vector<double> start = {0.3, 1.1, 0.4, -0.2}, pull = {0.93};
  const FlowMapResult result = flow_map.run(start, pull, steps(10.0, 50));
  CHECK(result.status == FlowMapStatus::left_box);
  CHECK(result.left == "angle");
  CHECK(result.reached > 0.5);
  CHECK_THAT(result.message, Contains("the flow map left the box at t = ") && Contains("angle = ") &&
                                 Contains("is outside [-1.57") && !Contains("half turn"));
}
