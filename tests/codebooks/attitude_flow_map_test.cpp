// Windows of bodies with an attitude: they start at a tilt, yaw and place are put back.
#include <cmath>
#include <functional>
#include <random>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/composition/flow_map.h"
#include "samara/codebooks/composition/reduced_attitude.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A position, a vector and a quaternion, in that order, and a number that nothing turns.
samara::models::ModelInfo moving_thing() {
  using samara::models::StateGroupKind;
  samara::models::ModelInfo info;
  info.groups = {{.kind = StateGroupKind::position, .first = 0},
                 {.kind = StateGroupKind::vector, .first = 3},
                 {.kind = StateGroupKind::quaternion, .first = 6}};
  return info;
}
constexpr int kNumbers = 11, kQuaternion = 6;

VectorXd random_state(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  VectorXd x(kNumbers);
  for (double& number : x) number = normal(random);
  return x;
}

/// d(map)/dx by central differences.
MatrixXd slopes(const std::function<VectorXd(const VectorXd&)>& map, const VectorXd& x, double h) {
  MatrixXd result(map(x).size(), x.size());
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    VectorXd ahead = x, behind = x;
    ahead[j] += h;
    behind[j] -= h;
    result.col(j) = (map(ahead) - map(behind)) / (2.0 * h);
  }
  return result;
}

/// The world turned about the vertical, and the quaternion stretched.
VectorXd turned(const VectorXd& x, double angle, double stretch) {
  const double c = std::cos(0.5 * angle), s = std::sin(0.5 * angle);
  VectorXd y = x;
  for (const int v : {0, 3}) {
    y[v] = std::cos(angle) * x[v] - std::sin(angle) * x[v + 1];
    y[v + 1] = std::sin(angle) * x[v] + std::cos(angle) * x[v + 1];
  }
  const Eigen::Vector4d q = x.segment<4>(kQuaternion);
  y.segment<4>(kQuaternion) << c * q[0] - s * q[3], c * q[1] - s * q[2], c * q[2] + s * q[1],
      c * q[3] + s * q[0];
  y.segment<4>(kQuaternion) *= stretch;
  return y;
}

}  // namespace

TEST_CASE("a reduced attitude knows neither yaw nor the length of the quaternion, and is put back exactly") {
  std::mt19937_64 random(3);
  const ReducedAttitude attitude(moving_thing(), kQuaternion, 1.0, true);
  for (int k = 0; k < 20; ++k) {
    const VectorXd x = random_state(random);
    const VectorXd r = attitude.reduced(x, nullptr);
    CHECK(r[kQuaternion] == 1.0);
    CHECK(r[kQuaternion + 3] == 0.0);
    CHECK((attitude.reduced(turned(x, 2.0 * k, -0.3), nullptr) - r).norm() < 1e-11 * (1.0 + r.norm()));
    CHECK((attitude.restored(r, x, nullptr, nullptr) - x).norm() < 1e-13 * x.norm());
    // The tilt is as steep: the vertical in body axes, to which yaw does nothing.
    const auto upright = [](const VectorXd& s) {
      const Eigen::Vector4d q = s.segment<4>(kQuaternion).normalized();
      return 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]);
    };
    CHECK(upright(r) == Approx(upright(x)).margin(1e-12));
  }
}

TEST_CASE("without the symmetry only the length of the quaternion goes") {
  std::mt19937_64 random(4);
  const ReducedAttitude attitude(moving_thing(), kQuaternion, 1.0, false);
  const VectorXd x = random_state(random);
  const VectorXd r = attitude.reduced(x, nullptr);
  CHECK((r.segment<4>(kQuaternion) - x.segment<4>(kQuaternion) / x[kQuaternion]).norm() < 1e-14);
  CHECK(r.head(6) == x.head(6));
  CHECK((attitude.restored(r, x, nullptr, nullptr) - x).norm() < 1e-14 * x.norm());
}

TEST_CASE("the derivatives of reducing and of putting back are those of central differences") {
  std::mt19937_64 random(5);
  for (const bool without_yaw : {true, false}) {
    const ReducedAttitude attitude(moving_thing(), kQuaternion, 0.7, without_yaw);
    for (int k = 0; k < 10; ++k) {
      VectorXd x = random_state(random);
      x[kQuaternion] += 2.0;  // far from upside down, where slopes are steep
      const VectorXd y = random_state(random);
      MatrixXd by_x, by_y, by_heading;
      attitude.reduced(x, &by_x);
      attitude.restored(y, x, &by_y, &by_heading);
      // Second-order differences of h = 1e-5 leave 1e-10 of the third derivatives.
      const auto reduced = [&](const VectorXd& at) { return attitude.reduced(at, nullptr); };
      const auto of_y = [&](const VectorXd& at) { return attitude.restored(at, x, nullptr, nullptr); };
      const auto of_x = [&](const VectorXd& at) { return attitude.restored(y, at, nullptr, nullptr); };
      CHECK((by_x - slopes(reduced, x, 1e-5)).cwiseAbs().maxCoeff() < 1e-8);
      CHECK((by_y - slopes(of_y, y, 1e-5)).cwiseAbs().maxCoeff() < 1e-8);
      CHECK((by_heading - slopes(of_x, x, 1e-5)).cwiseAbs().maxCoeff() < 1e-8);
    }
  }
}

namespace {

/// A bottom-heavy body with a full added mass, a little heavier than the fluid; how much is free.
const std::string kBody = R"toml(model = "kirchhoff_body"
[fixed]
mass = 1.0
I_xx = 0.4
I_yy = 0.6
I_zz = 0.9
r_cz = -0.05
K_11 = 0.1
K_22 = 0.2
K_33 = 0.6
K_15 = 0.05
K_24 = -0.04
K_44 = 0.05
K_55 = 0.1
)toml";

Codebook window(const std::string& attitude_axes, const std::string& tolerance = "4e-3") {
  return build(parse_plan(kBody + "[box]\n" + attitude_axes + R"toml("ux(0)" = [-0.3, 0.3]
"uy(0)" = [-0.3, 0.3]
"uz(0)" = [-0.6, 0.2]
"wx(0)" = [-0.6, 0.6]
"wy(0)" = [-0.6, 0.6]
"wz(0)" = [-0.4, 0.4]
displaced_mass = [0.85, 0.95]
[time]
end = 0.1
[tolerance]
relative = )toml" + tolerance +
                              "\n[builder]\nkind = \"sampling\"\n",
                          "window.toml"),
               {.certificate_points = 100})
      .book;
}

const Codebook& tilted_window() {
  static const Codebook book = window("\"qx(0)\" = [-0.3, 0.3]\n\"qy(0)\" = [-0.3, 0.3]\n");
  return book;
}

/// Turned to the west, tilted a little, on its way, somewhere.
std::vector<double> start() {
  const double yaw = 2.2, tilt = 0.3;
  const double c = std::cos(0.5 * yaw), s = std::sin(0.5 * yaw);
  const double w = std::cos(0.5 * tilt), x = 0.6 * std::sin(0.5 * tilt), y = 0.8 * std::sin(0.5 * tilt);
  return {5.0, -7.0, 2.0, c * w, c * x - s * y, c * y + s * x, s * w, 0.1, -0.05, -0.1, 0.2, -0.15, 0.3};
}

constexpr double kDisplaced = 0.91;

/// The start, and the displaced mass.
VectorXd free_values() {
  const std::vector<double> x = start();
  VectorXd q(14);
  q << Eigen::Map<const VectorXd>(x.data(), 13), kDisplaced;
  return q;
}

samara::models::ParametricModel body_model() {
  const Plan plan = parse_plan(kBody + "[box]\ndisplaced_mass = [0.8, 1]\n[time]\nend = 1\n", "body.toml");
  std::vector<std::string> free;
  const auto model = samara::models::find_model("kirchhoff_body");
  for (const auto& state : model->info().states) free.push_back(state.name + "(0)");
  free.push_back("displaced_mass");
  return {model, plan.fixed, free};
}

}  // namespace

TEST_CASE("windows that start at a tilt carry a body at any yaw and place, with derivatives") {
  REQUIRE(tilted_window().certificate()->met);
  FlowMap flow_map(tilted_window());
  CHECK(flow_map.states().size() == 13);
  const std::vector<double> times = {0.0, 0.05, 0.1, 0.25, 0.5};
  const FlowMapResult result = flow_map.run(start(), std::vector{kDisplaced}, times, true);
  INFO(result.message);
  REQUIRE(result.status == FlowMapStatus::done);
  const VectorXd q = free_values();
  const auto exact =
      samara::models::integrate(body_model(), std::vector<double>(q.begin(), q.end()), times, {}, true);
  // Five windows, each good to 4e-3 of ranges up to 1.
  CHECK((result.states - exact.states).cwiseAbs().maxCoeff() < 5 * 4e-3);
  // Even places and attitudes, whose ranges over a window are a tenth of that.
  CHECK((result.states - exact.states).leftCols(7).cwiseAbs().maxCoeff() < 5 * 4e-4);
  for (std::size_t j = 0; j < 14; ++j) {
    INFO("by " << j);
    const VectorXd found = result.derivatives[4].col(static_cast<Eigen::Index>(j));
    CHECK((found - exact.sensitivities[j].row(4).transpose()).cwiseAbs().maxCoeff() < 0.1);
  }
}

TEST_CASE("composed derivatives through attitudes are those of the flow map itself") {
  FlowMap flow_map(tilted_window());
  const std::vector<double> times = {0.35};
  const FlowMapResult result = flow_map.run(start(), std::vector{kDisplaced}, times, true);
  const auto end = [&](const VectorXd& q) -> VectorXd {
    return flow_map.run(std::vector<double>(q.begin(), q.begin() + 13), std::vector{q[13]}, times)
        .states.row(0);
  };
  CHECK((result.derivatives[0] - slopes(end, free_values(), 1e-5)).cwiseAbs().maxCoeff() < 1e-7);
}

TEST_CASE("turning the world and stretching the quaternion turns and stretches what a flow map answers") {
  FlowMap flow_map(tilted_window());
  const std::vector<double> at = start();
  const auto same = [](const VectorXd& x) {  // place and quaternion as the states of moving_thing()
    VectorXd y = VectorXd::Zero(kNumbers);
    y.head<3>() = x.head<3>();
    y.segment<4>(kQuaternion) = x.segment<4>(3);
    return y;
  };
  const VectorXd x = Eigen::Map<const VectorXd>(at.data(), 13);
  const VectorXd other = turned(same(x), 1.3, -2.0);
  std::vector<double> from = at;
  std::copy_n(other.begin(), 3, from.begin());
  std::copy_n(other.begin() + kQuaternion, 4, from.begin() + 3);
  const VectorXd end = flow_map.run(at, std::vector{kDisplaced}, std::vector{0.4}).states.row(0);
  const VectorXd turned_end = flow_map.run(from, std::vector{kDisplaced}, std::vector{0.4}).states.row(0);
  CHECK((same(turned_end) - turned(same(end), 1.3, -2.0)).norm() < 1e-12);
  CHECK((turned_end - end).tail<6>().norm() < 1e-12);
}

TEST_CASE("a body that tilts out of the box, and a codebook without a tilt, are named") {
  FlowMap flow_map(tilted_window());
  std::vector<double> steep = start();
  steep[3] = 1.0, steep[4] = 0.5, steep[5] = 0.0, steep[6] = 0.0;
  const FlowMapResult result = flow_map.run(steep, std::vector{kDisplaced}, std::vector{0.4});
  CHECK(result.status == FlowMapStatus::left_box);
  CHECK(result.left == "qx");
  CHECK_THAT(result.message,
             Contains("qx = 0.5") && Contains("outside [-0.3, 0.3]") && Contains("without yaw"));
  steep[3] = 0.0;  // upside down
  CHECK(flow_map.run(steep, std::vector{kDisplaced}, std::vector{0.4}).status == FlowMapStatus::left_box);

  const Codebook flat = window("\"qx(0)\" = [-0.3, 0.3]\n", "0.5");
  CHECK_THROWS_WITH(FlowMap(flat), Contains("the axes \"qx(0)\" and \"qy(0)\", with \"qw(0)\" fixed at 1 and "
                                            "\"qz(0)\" at 0"));
}

namespace {

/// Upright and upside down alike: its axes are those of its inertia and of its added mass.
std::string rolling_body(const std::string& more, const std::string& tolerance) {
  return "model = \"kirchhoff_body\"\n[fixed]\nmass = 1.0\nI_xx = 0.4\nI_yy = 0.6\nI_zz = 0.9\n"
         "K_11 = 0.1\nK_22 = 0.2\nK_33 = 0.6\nK_44 = 0.05\nK_55 = 0.1\ndisplaced_mass = 0.98\n" +
         more + R"toml([box]
"qx(0)" = [-1.02, 1.02]
"qy(0)" = [-0.5, 0.5]
"ux(0)" = [-0.3, 0.3]
"uy(0)" = [-0.38, 0.38]
"uz(0)" = [-0.38, 0.38]
"wx(0)" = [2.5, 3.5]
"wy(0)" = [-0.4, 0.4]
"wz(0)" = [-0.4, 0.4]
[time]
end = 0.1
[tolerance]
relative = )toml" +
         tolerance + "\n[builder]\nkind = \"sampling\"\n";
}

FlowMapResult rolled(const std::string& more, const std::string& tolerance, const std::vector<double>& start,
                     const std::vector<double>& times, bool with_derivatives,
                     samara::models::Trajectory& exact) {
  const Plan plan = parse_plan(rolling_body(more, tolerance), "rolling.toml");
  const BuildResult window = build(plan, {.certificate_points = 30});
  INFO(window.message);
  REQUIRE(window.met);
  std::vector<std::string> free;
  const auto model = samara::models::find_model("kirchhoff_body");
  for (const auto& state : model->info().states) free.push_back(state.name + "(0)");
  exact = samara::models::integrate({model, plan.fixed, free}, start, times, {}, with_derivatives);
  FlowMap flow_map(window.book);
  return flow_map.run(start, {}, times, with_derivatives);
}

}  // namespace

TEST_CASE(
    "a body that is alike upright and upside down rolls on through windows that start at tilts up to a "
    "right angle") {
  const std::vector<double> start = {5.0, -7.0, 2.0, 0.9, 0.2, 0.1, 0.4, 0.1, -0.05, -0.1, 3.0, 0.1, -0.1};
  const std::vector<double> times = {0.3, 0.65, 1.0, 1.5, 3.0};
  samara::models::Trajectory exact;
  const FlowMapResult result = rolled("", "2e-3", start, times, true, exact);
  INFO(result.message);
  // It falls on, faster than the box holds in the end.
  CHECK(result.status == FlowMapStatus::left_box);
  CHECK_THAT(result.message, Contains("uy = ") || Contains("uz = "));
  REQUIRE(result.reached == 1.5);
  // Upside down on the way, and upright again.
  const auto upright = [&](Eigen::Index i) {
    const Eigen::Vector4d q = exact.states.row(i).segment<4>(3).transpose().normalized();
    return 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]);
  };
  CHECK(upright(2) < -0.8);
  CHECK(upright(3) > 0.2);
  // Fifteen windows, each good to 2e-3 of ranges up to 1; even places and attitudes, whose ranges are a tenth of that.
  const MatrixXd errors = (result.states - exact.states).topRows(4).cwiseAbs();
  CHECK(errors.maxCoeff() < 15 * 2e-3);
  CHECK(errors.leftCols(7).maxCoeff() < 15 * 4e-4);
  for (std::size_t j = 0; j < 13; ++j) {
    INFO("by " << j);
    const VectorXd found = result.derivatives[3].col(static_cast<Eigen::Index>(j));
    const VectorXd wanted = exact.sensitivities[j].row(3).transpose();
    CHECK((found - wanted).cwiseAbs().maxCoeff() < 0.1 * (1.0 + wanted.cwiseAbs().maxCoeff()));
  }
}

TEST_CASE("a bottom-heavy body leaves the box where it turns over, and it is said when") {
  const std::vector<double> start = {0, 0, 0, 0.9, 0.2, 0.1, 0.4, 0.1, -0.05, -0.1, 3.0, 0.1, -0.1};
  samara::models::Trajectory exact;
  const FlowMapResult result = rolled("r_cz = -0.01\n", "5e-2", start, {0.2, 1.0}, false, exact);
  CHECK(result.status == FlowMapStatus::left_box);
  CHECK_THAT(result.left, Contains("q"));
  CHECK(result.reached == 0.2);
}
