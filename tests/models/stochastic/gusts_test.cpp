#include <memory>
#include <numbers>

#include <catch2/catch.hpp>

#include "../bodies_in_flow.h"
#include "samara/base/errors.h"
#include "samara/base/normals.h"
#include "samara/models/laws/ambient_flow.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/fluid_seen.h"
#include "samara/models/stochastic/gust_layout.h"
#include "samara/models/stochastic/realisations.h"
#include "samara/models/stochastic/turbulent_flow.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

using Parameters = std::map<std::string, double>;

const Parameters kLeaf = {{"a", 0.035},   {"b", 0.02},   {"c", 1e-4},   {"density", 1200.0}, {"C_D90", 0.61},
                          {"C_D0", 0.05}, {"C_T", 1.81}, {"C_R", 1.21}, {"C_w", 2.0}};
const Parameters kPlate = {{"semi_chord", 0.02}, {"semi_thickness", 0.002}, {"density", 1500.0}, {"mu1", 0.0},
                           {"mu2", 0.2},         {"speed_floor", 1e-4}};

Parameters ramp(const Eigen::Vector3d& velocity, const Eigen::Vector3d& rate) {
  Parameters values;
  const char* axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    values[std::string("gust_") + axes[i]] = velocity[i];
    values[std::string("gust_rate_") + axes[i]] = rate[i];
  }
  return values;
}

Eigen::MatrixXd states_of(const std::string& model, const Parameters& values,
                          const std::vector<double>& times) {
  const ParametricModel fixed(find_model(model), values, {});
  return integrate(fixed, {}, times, {.relative_tolerance = 1e-12, .max_steps = 1000000}).states;
}

/// w_air = w_0 + a t
class Accelerating final : public AmbientFlow {
 public:
  AmbientSample sample(double t, const Eigen::Vector3d&) const override {
    return {.velocity = velocity + t * rate, .rate = rate};
  }
  double length() const override { return 1.0; }
  Eigen::Vector3d velocity = {1.0, -0.5, 0.3};
  Eigen::Vector3d rate = {4.0, 2.0, -3.0};
};

/// Starts from rest and jumps about from step to step, by numbers that a test may draw again.
class JumpyAir final : public AirSource {
 public:
  static Eigen::Vector3d velocity(std::uint64_t number, std::uint64_t step) {
    if (step == 0) return Eigen::Vector3d::Zero();
    const auto z = samara::normals_at(9, {.realisation = number, .step = step});
    return {z[0], z[1], z[2]};
  }
  std::unique_ptr<AirAlongPath> realisation(std::uint64_t number, bool) const override {
    return std::make_unique<Path>(number);
  }

 private:
  class Path final : public AirAlongPath {
   public:
    explicit Path(std::uint64_t number) : number_(number) {}
    AirSeen start(const BodyOnPath&) override { return {}; }
    AirSeen step(const BodyOnPath&, double) override { return {.velocity = velocity(number_, ++step_)}; }

   private:
    std::uint64_t number_, step_ = 0;
  };
};

/// Largest distance of the velocity of bodies from the air they were told of, over 200 steps of 3 realisations.
double distance_from_air(const std::string& name, const Parameters& values) {
  const ParametricModel model(find_model(name), values, {});
  std::vector<double> times;
  for (int k = 0; k <= 200; ++k) times.push_back(1e-3 * k);
  const Ensemble cloud =
      realise(model, {}, JumpyAir(), times, {.realisations = 3, .step = 1.001e-3, .keep = 3});
  const GustLayout layout(model.model());
  double worst = 0.0;
  for (std::size_t n = 0; n < cloud.kept.size(); ++n) {
    for (Eigen::Index k = 0; k < cloud.times.size(); ++k) {
      BodyOnPath body;
      layout.read([&](int i) { return cloud.kept[n](k, i); }, body);
      Eigen::Vector3d air = JumpyAir::velocity(n, static_cast<std::uint64_t>(k));
      if (layout.space() == GustLayout::Space::plane) air.y() = 0.0;
      worst = std::max(worst, (body.velocity - air).norm());
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("a body in a ramp of gusts moves as in a flow that accelerates") {
  const std::vector<double> times = {0.1, 0.4};
  const Accelerating flow;
  BodyState start;
  start.q = Eigen::Quaterniond(0.9, 0.3, -0.2, 0.1).normalized();
  start.w = {3.0, -2.0, 1.0};
  const Eigen::MatrixXd in_flow =
      motion(immersed_body_in(std::make_shared<Accelerating>()), kLeaf, start, times);
  const Eigen::MatrixXd in_gusts = motion(find_model("immersed_body_in_gusts"),
                                          joined(kLeaf, ramp(flow.velocity, flow.rate)), start, times);
  CHECK((in_flow - in_gusts).cwiseAbs().maxCoeff() < 1e-8);
}

TEST_CASE(
    "in a fluid that accelerates upward bodies move relative to it as in a still one with more weight") {
  // An ellipsoid with its masses off the origin, a blimp with a gondola, and a body whose buoyancy acts off its centre
  // of mass; all turn.
  const Parameters any = {{"mass", 0.3},   {"displaced_mass", 0.2}, {"qw(0)", 0.2},  {"qx(0)", 0.9},
                          {"qy(0)", -0.3}, {"qz(0)", 0.1},          {"ux(0)", 2.0},  {"uy(0)", -0.3},
                          {"uz(0)", 0.4},  {"wx(0)", 0.5},          {"wy(0)", -1.0}, {"wz(0)", 0.8}};
  const Parameters kirchhoff = joined(any, {{"I_xx", 0.02},
                                            {"I_yy", 0.03},
                                            {"I_zz", 0.025},
                                            {"I_xy", 0.002},
                                            {"r_cx", 0.05},
                                            {"r_cy", -0.03},
                                            {"r_cz", 0.04},
                                            {"r_bx", -0.02},
                                            {"r_bz", 0.06},
                                            {"K_11", 0.1},
                                            {"K_22", 0.2},
                                            {"K_33", 0.3},
                                            {"K_12", 0.02},
                                            {"K_15", 0.01},
                                            {"K_44", 0.004},
                                            {"K_55", 0.006},
                                            {"K_66", 0.005}});
  const Parameters blimp =
      joined(any, {{"I_x", 0.03},  {"I_y", 0.05},         {"I_z", 0.04},       {"r_cx", 0.02},
                   {"r_cz", 0.03}, {"offset_mass", 0.05}, {"offset_x", 0.1},   {"offset_z", 0.2},
                   {"area", 0.3},  {"M_x", 0.05},         {"M_y", 0.15},       {"M_z", 0.2},
                   {"J_y", 0.01},  {"thrust_left", 0.1},  {"thrust_arm", 0.1}, {"Cd0", 0.2},
                   {"Cda", 1.0},   {"Cla", 1.5},          {"Csb", -1.0},       {"Cmya", -0.1},
                   {"Cmzb", 0.1},  {"K1", -0.01},         {"K2", -0.02},       {"K3", -0.015}});
  const Parameters lopsided = joined(any, {{"a", 0.35},
                                           {"b", 0.2},
                                           {"c", 0.1},
                                           {"density", 10.0},
                                           {"I_x", 0.02},
                                           {"I_y", 0.03},
                                           {"I_z", 0.025},
                                           {"r_bx", 0.01},
                                           {"r_by", -0.02},
                                           {"r_bz", 0.03},
                                           {"C_D90", 0.6},
                                           {"C_D0", 0.05},
                                           {"C_T", 0.9},
                                           {"C_R", 1.2},
                                           {"C_w", 2.0},
                                           {"kappa", 0.5}});
  const Eigen::Vector3d stream(1.5, -0.7, 0.4), up(0.0, 0.0, 2.5);
  const std::vector<double> times = {0.15, 0.5};
  for (const auto& [name, values] :
       {std::pair{"kirchhoff_body", kirchhoff}, std::pair{"coefficient_body", blimp},
        std::pair{"immersed_body", lopsided}}) {
    INFO(name);
    const Eigen::MatrixXd still = states_of(name, joined(values, {{"g", 9.81 + up.z()}}), times);
    // The same velocity relative to the fluid at the start.
    const auto turn = [](const auto& q) { return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(); };
    const Eigen::Vector3d told = turn(std::array{0.2, 0.9, -0.3, 0.1}).conjugate() * stream;
    Parameters moved = joined(values, ramp(stream, up));
    const char* const velocities[] = {"ux(0)", "uy(0)", "uz(0)"};
    for (int i = 0; i < 3; ++i) moved[velocities[i]] += told[i];
    const Eigen::MatrixXd carried = states_of(std::string(name) + "_in_gusts", moved, times);
    for (Eigen::Index k = 0; k < still.rows(); ++k) {
      const double t = times[static_cast<std::size_t>(k)];
      const Eigen::Vector3d way = stream * t + 0.5 * up * t * t;
      CHECK((carried.row(k).head<3>() - still.row(k).head<3>() - way.transpose()).norm() < 1e-9);
      CHECK((carried.row(k).segment<4>(3) - still.row(k).segment<4>(3)).norm() < 1e-9);
      CHECK((carried.row(k).tail<3>() - still.row(k).tail<3>()).norm() < 1e-8);
      const Eigen::Vector4d q = carried.row(k).segment<4>(3);
      const Eigen::Vector3d air = turn(q).conjugate() * Eigen::Vector3d(stream + t * up);
      CHECK((carried.row(k).segment<3>(7) - still.row(k).segment<3>(7) - air.transpose()).norm() < 1e-8);
    }
  }
}

TEST_CASE("in a mean flow with a gradient the ramps lead to the motion in that flow, to second order") {
  // w_air = w_0 + A x + b t, without any turbulence.
  Eigen::Matrix3d A;
  A << 0.8, 0.3, 1.5, -0.4, 0.2, 0.6, 0.5, -0.7, -1.0;
  const auto sample = [A](double t, const Eigen::Vector3d& x) {
    const Eigen::Vector3d rate(0.5, -0.8, 0.3);
    return AmbientSample{
        .velocity = Eigen::Vector3d(0.4, 0.0, 0.2) + A * x + rate * t, .gradient = A, .rate = rate};
  };
  const auto flow = turbulent_flow(
      sample, [](double, const Eigen::Vector3d&) { return Turbulence{.epsilon = 1.0}; }, 1.0);
  // Light, so that the pressure gradient counts.
  const Parameters body = joined(kLeaf, {{"density", 30.0}, {"qw(0)", 0.9}, {"qx(0)", 0.3}, {"qy(0)", -0.2}});
  const std::vector<double> times = {0.2};
  const Eigen::RowVectorXd exact =
      integrate(ParametricModel(immersed_body_in(flow), body, {}), {}, times, {.relative_tolerance = 1e-11})
          .states.row(0);
  const ParametricModel in_gusts(find_model("immersed_body_in_gusts"), body, {});
  double errors[2];
  for (const int halvings : {0, 1}) {
    const Ensemble cloud = realise(in_gusts, {}, *fluid_seen_in(flow, 1), times,
                                   {.realisations = 1, .step = 1e-3 / (1 << halvings), .keep = 1});
    errors[halvings] = (cloud.kept[0].row(0) - exact).head<3>().norm();
  }
  CHECK(errors[0] < 1e-4);
  CHECK(errors[0] / errors[1] > 3.0);
}

TEST_CASE("the radius that averages the fluid is that of the outline") {
  const auto radius = [](const char* name, const Parameters& values) {
    const auto model = find_model(name);
    return outline_radius(model->info(), parameter_values(*model, values).value);
  };
  CHECK_THAT(radius("immersed_body_in_gusts", kLeaf), WithinRel(std::sqrt(0.035 * 0.02), 1e-14));
  CHECK(radius("falling_plate_in_gusts", kPlate) == 0.02);
  CHECK(radius("sphere_flight_in_gusts", {}) == 0.02);
  CHECK(radius("constant_rate", {{"k", 1.0}}) == 0.0);
}

TEST_CASE("a plate sees of the world its plane, and turns in the sense of theta") {
  const auto model = find_model("falling_plate_in_gusts");
  const GustLayout layout(*model);
  std::map<std::string, double> set;
  layout.write(
      [&](int j, double value) { set[model->info().parameters[static_cast<std::size_t>(j)].name] = value; },
      0.5, {1.0, 2.0, 3.0}, {4.0, 5.0, 6.0},
      Eigen::Matrix3d({{21.0, 22.0, 23.0}, {24.0, 25.0, 26.0}, {27.0, 28.0, 29.0}}), {10.0, -11.0, 12.0});
  CHECK(set == std::map<std::string, double>{{"gust_start", 0.5},
                                             {"gust_x", 1.0},
                                             {"gust_y", 3.0},
                                             {"gust_rate_x", 4.0},
                                             {"gust_rate_y", 6.0},
                                             {"gust_gradient_xx", 21.0},
                                             {"gust_gradient_xy", 23.0},
                                             {"gust_gradient_yx", 27.0},
                                             {"gust_gradient_yy", 29.0},
                                             {"gust_spin", 11.0}});
  BodyOnPath body;
  const double states[] = {2.0, 1.0, 0.0, 0.5, 0.3, 0.4};
  layout.read([&](int i) { return states[i]; }, body);
  CHECK(body.position == Eigen::Vector3d(0.3, 0.0, 0.4));
  CHECK_THAT(body.velocity.x(), WithinAbs(2.0 * std::cos(0.5) - std::sin(0.5), 1e-15));
  CHECK_THAT(body.velocity.z(), WithinAbs(2.0 * std::sin(0.5) + std::cos(0.5), 1e-15));
  CHECK_THAT(body.attitude.determinant(), WithinRel(1.0, 1e-14));
}

TEST_CASE("a fluid that accelerates acts as a weight the other way on bodies in it") {
  // In the frame of the fluid gravity is g - a: with a = 2 upward, 11.81.
  constexpr double a = 2.0;
  const std::vector<double> times = {0.1, 0.3};
  SECTION("plate") {
    const Parameters gust = {{"gust_rate_y", a}};
    Eigen::MatrixXd heavy = states_of("falling_plate", joined(kPlate, {{"g", 9.81 + a}}), times);
    const Eigen::MatrixXd lifted = states_of("falling_plate_in_gusts", joined(kPlate, gust), times);
    for (Eigen::Index k = 0; k < 2; ++k) {
      const double t = times[static_cast<std::size_t>(k)], theta = heavy(k, 3);
      heavy.row(k) += Eigen::RowVectorXd{
          {a * t * std::sin(theta), a * t * std::cos(theta), 0.0, 0.0, 0.0, 0.5 * a * t * t}};
    }
    CHECK((heavy - lifted).cwiseAbs().maxCoeff() < 1e-8);
  }
  SECTION("sphere") {
    const Parameters gust = {{"gust_rate_z", a}, {"wy(0)", 50.0}};
    Eigen::MatrixXd heavy = states_of("sphere_flight", {{"g", 9.81 + a}, {"wy(0)", 50.0}}, times);
    const Eigen::MatrixXd lifted = states_of("sphere_flight_in_gusts", gust, times);
    for (Eigen::Index k = 0; k < 2; ++k) {
      const double t = times[static_cast<std::size_t>(k)];
      heavy(k, 2) += 0.5 * a * t * t;
      heavy(k, 5) += a * t;
    }
    CHECK((heavy - lifted).cwiseAbs().maxCoeff() < 1e-8);
  }
}

TEST_CASE("a steady gust only carries a plate along") {
  const std::vector<double> times = {0.2, 0.5};
  Eigen::MatrixXd still = states_of("falling_plate", kPlate, times);
  const double theta_0 = 0.4;
  const Eigen::MatrixXd carried =
      states_of("falling_plate_in_gusts",
                joined(kPlate, {{"gust_x", 0.7},
                                {"gust_y", -0.2},
                                {"vx(0)", 0.7 * std::cos(theta_0) - 0.2 * std::sin(theta_0)},
                                {"vy(0)", -0.7 * std::sin(theta_0) - 0.2 * std::cos(theta_0)}}),
                times);
  for (Eigen::Index k = 0; k < 2; ++k) {
    const double t = times[static_cast<std::size_t>(k)];
    CHECK_THAT(carried(k, 3), WithinAbs(still(k, 3), 1e-8));
    CHECK_THAT(carried(k, 4), WithinAbs(still(k, 4) + 0.7 * t, 1e-8));
    CHECK_THAT(carried(k, 5), WithinAbs(still(k, 5) - 0.2 * t, 1e-8));
  }
}

TEST_CASE("a body that turns with the fluid feels no damping, and one at rest is turned by it") {
  const auto model = find_model("immersed_body_in_gusts");
  BodyState with_it;
  with_it.w = {5.0, -3.0, 0.0};
  const Parameters spin = {{"gust_spin_x", 5.0}, {"gust_spin_y", -3.0}};
  std::vector<Wrench> terms(model->info().force_terms.size());
  model->forces(0.0, with_it.vector(), parameter_values(*model, joined(kLeaf, spin)), terms);
  CHECK(terms[4].torque.norm() < 1e-18);
  model->forces(0.0, BodyState().vector(), parameter_values(*model, joined(kLeaf, spin)), terms);
  const Eigen::Vector3d turning = terms[4].torque;
  model->forces(0.0, with_it.vector(), parameter_values(*model, kLeaf), terms);
  CHECK((turning + terms[4].torque).norm() < 1e-12 * turning.norm());
  CHECK(turning.x() > 0.0);
}

TEST_CASE("a body as heavy as the fluid follows it at every step, whatever its added mass") {
  CHECK(distance_from_air(
            "immersed_body_in_gusts",
            joined(kLeaf, {{"density", 1.2}, {"M_z", 3e-5}, {"M_x", 1e-7}, {"qw(0)", 0.9}, {"qx(0)", 0.4}})) <
        1e-12);
  CHECK(distance_from_air("sphere_flight_in_gusts",
                          {{"mass", 4e-5}, {"displaced_mass", 4e-5}, {"added_mass", 7e-5}}) < 1e-12);
  CHECK(distance_from_air("falling_plate_in_gusts", joined(kPlate, {{"density", 998.2}})) < 1e-12);
}

TEST_CASE("a body far heavier than the fluid keeps its velocity") {
  const Parameters heavy = {{"mass", 1e6}, {"g", 0.0}, {"vx(0)", 2.0}};
  const ParametricModel model(find_model("sphere_flight_in_gusts"), heavy, {});
  const std::vector<double> times = {0.5};
  const Ensemble cloud =
      realise(model, {}, JumpyAir(), times, {.realisations = 4, .states = {"vx", "vy", "vz"}, .keep = 4});
  for (const Eigen::MatrixXd& path : cloud.kept) {
    CHECK_THAT(path(0, 3), WithinAbs(2.0, 1e-7));
    CHECK_THAT(path(0, 4), WithinAbs(0.0, 1e-7));
  }
}

TEST_CASE("what follows a gust at once is what pressure and added mass carry") {
  const auto model = find_model("immersed_body_in_gusts");
  const ParameterValues p = parameter_values(*model, kLeaf);
  BodyState state;
  state.q = Eigen::Quaterniond(0.9, 0.3, -0.2, 0.1).normalized();
  const Eigen::Matrix3d follows = GustLayout(*model).follows(*model, state.vector(), p);
  const double m = parameter(*model, p, "mass"), m_f = parameter(*model, p, "displaced_mass");
  const char* added[] = {"M_x", "M_y", "M_z"};
  for (int i = 0; i < 3; ++i) {
    const double M = parameter(*model, p, added[i]);
    CHECK_THAT(follows(i, i), WithinRel((m_f + M) / (m + M), 1e-9));
    CHECK_THAT(follows(i, (i + 1) % 3), WithinAbs(0.0, 1e-12));
  }
}

TEST_CASE("models that gusts cannot reach are refused with what they lack") {
  const ParametricModel still(find_model("immersed_body"), kLeaf, {});
  const std::vector<double> times = {0.1};
  CHECK_THROWS_WITH(realise(still, {}, JumpyAir(), times),
                    Catch::Matchers::Contains("model \"immersed_body\" has no parameter gust_start"));
  const ParametricModel held(find_model("immersed_body_in_gusts"), joined(kLeaf, {{"gust_x", 1.0}}), {});
  CHECK_THROWS_WITH(realise(held, {}, JumpyAir(), times),
                    Catch::Matchers::Contains("gust_x was given a value"));
}
