#include <numbers>

#include <catch2/catch.hpp>

#include "bodies_in_flow.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

using Values = std::map<std::string, double>;

/// The motion of a sphere from rest at the origin but for v and w.
Eigen::MatrixXd flight(Values values, const Eigen::Vector3d& v, const Eigen::Vector3d& w,
                       const std::vector<double>& times, const char* name = "sphere_flight") {
  const char* axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    values[std::string("v") + axes[i] + "(0)"] = v[i];
    values[std::string("w") + axes[i] + "(0)"] = w[i];
  }
  const ParametricModel model(find_model(name), values, {});
  const Trajectory trajectory = integrate(model, {}, times, {.relative_tolerance = 1e-12});
  REQUIRE(trajectory.is_usable());
  return trajectory.states;
}

}  // namespace

TEST_CASE("a sphere without drag and spin flies a parabola, with buoyancy and added mass") {
  const Values values = {{"C_D", 0.0}, {"C_M", 0.0}, {"fluid_density", 900.0}, {"mass", 0.1}};
  const double m_f = std::numbers::pi / 6.0 * 900.0 * 6.4e-5;
  const double a = -(0.1 - m_f) * 9.81 / (0.1 + m_f / 2.0);
  const Eigen::MatrixXd states = flight(values, {1.0, 2.0, 3.0}, {0.0, 0.0, 0.0}, {0.5, 1.0});
  CHECK_THAT(states(1, 0), WithinRel(1.0, 1e-10));
  CHECK_THAT(states(1, 1), WithinRel(2.0, 1e-10));
  CHECK_THAT(states(1, 2), WithinRel(3.0 + a / 2.0, 1e-10));
}

TEST_CASE("a falling sphere reaches its terminal speed") {
  const Eigen::MatrixXd states = flight({{"C_D", 0.5}}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {30.0});
  const double m_f = std::numbers::pi / 6.0 * 1.2 * 6.4e-5;
  const double area = std::numbers::pi * 4e-4;
  CHECK_THAT(states(0, 5), WithinRel(-std::sqrt(2.0 * (2.7e-3 - m_f) * 9.81 / (1.2 * 0.5 * area)), 1e-7));
}

TEST_CASE("a spinning sphere without drag and weight flies in a circle, and its spin decays") {
  // (m + m_a) v' = k w x v with w along z: a circle of angular rate k w / (m + m_a), k = 1/2 rho A C_M r.
  const double w = 100.0;
  const double k = 0.5 * 1.2 * std::numbers::pi * 4e-4 * 1.0 * 0.02;
  const double m = 2.7e-3 + std::numbers::pi / 12.0 * 1.2 * 6.4e-5;
  const double rate = k * w / m;
  const Eigen::MatrixXd circle =
      flight({{"C_D", 0.0}, {"g", 0.0}}, {5.0, 0.0, 0.0}, {0.0, 0.0, w}, {0.5, 1.0});
  for (Eigen::Index row = 0; row < 2; ++row) {
    const double t = row == 0 ? 0.5 : 1.0;
    CHECK_THAT(circle(row, 3), WithinAbs(5.0 * std::cos(rate * t), 1e-9));
    CHECK_THAT(circle(row, 4), WithinAbs(5.0 * std::sin(rate * t), 1e-9));
    CHECK(circle(row, 8) == w);
  }
  const Eigen::MatrixXd decay = flight({{"spin_decay", 2.0}}, {5.0, 0.0, 0.0}, {10.0, 0.0, w}, {0.5});
  CHECK_THAT(decay(0, 6), WithinRel(10.0 * std::exp(-1.0), 1e-9));
  CHECK_THAT(decay(0, 8), WithinRel(w * std::exp(-1.0), 1e-9));
}

TEST_CASE("backspin lifts and topspin sinks") {
  // Forward along x; topspin turns the upper side forward: w along +y.
  const Eigen::MatrixXd top = flight({}, {8.0, 0.0, 0.0}, {0.0, 200.0, 0.0}, {0.3});
  const Eigen::MatrixXd none = flight({}, {8.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.3});
  const Eigen::MatrixXd back = flight({}, {8.0, 0.0, 0.0}, {0.0, -200.0, 0.0}, {0.3});
  CHECK(top(0, 2) < none(0, 2));
  CHECK(none(0, 2) < back(0, 2));
}

TEST_CASE("drag takes energy, the Magnus force none, and the terms sum to the rate of momentum") {
  const auto model = find_model("sphere_flight");
  const ParameterValues p = parameter_values(*model, {{"spin_decay", 0.3}});
  const double m = parameter(*model, p, "mass") + parameter(*model, p, "added_mass");
  std::mt19937 random(8);
  for (int k = 0; k < 100; ++k) {
    const Eigen::Vector3d v = random_vector(random, 5.0);
    const Eigen::Vector3d w = random_vector(random, 100.0);
    const std::vector<double> x = {0.0, 0.0, 0.0, v.x(), v.y(), v.z(), w.x(), w.y(), w.z()};
    std::vector<double> f(9);
    model->rhs(0.0, x, p, f);
    std::vector<Wrench> terms(4);
    model->forces(0.0, x, p, terms);
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    double power = 0.0;
    for (const Wrench& term : terms) {
      force += term.force;
      power += term.power;
    }
    const Eigen::Vector3d rate(f[3], f[4], f[5]);
    const Eigen::Vector3d spin_rate(f[6], f[7], f[8]);
    CHECK((m * rate - force).norm() < 1e-14 * force.norm());
    CHECK(terms[0].power < 0.0);
    CHECK(std::abs(terms[1].power) < 1e-15 * terms[1].force.norm() * v.norm());
    CHECK(terms[2].power < 0.0);
    const double energy_rate = m * v.dot(rate) + parameter(*model, p, "inertia") * w.dot(spin_rate);
    CHECK_THAT(power, WithinAbs(energy_rate, 1e-14 * force.norm() * v.norm()));
  }
}

TEST_CASE("a saturating Magnus force has half its slope where the spin parameter is the inverse saturation") {
  // b S = 1: C_L = C_M S/2. The floors change V and r |w| by 1e-7 of them at most.
  const double b = 2.5, speed = 4.0;
  const double w = speed / (b * 0.02);
  const auto model = find_model("sphere_flight");
  const std::vector<double> x = {0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0, 0.0, w};
  const auto magnus = [&](double saturation) {
    std::vector<Wrench> terms(4);
    model->forces(0.0, x, parameter_values(*model, {{"magnus_saturation", saturation}}), terms);
    return terms[1].force;
  };
  CHECK((magnus(b) - 0.5 * magnus(0.0)).norm() < 1e-7 * magnus(0.0).norm());
  CHECK_THAT(magnus(0.0).y(), WithinRel(0.5 * 1.2 * std::numbers::pi * 4e-4 * 0.02 * w * speed, 1e-6));
}

TEST_CASE("the drag of a spinning sphere is that of the sum of drag coefficient and spin_drag S") {
  // S = 0.5; the floors change V and r |w| by 1e-7 of them at most.
  const double speed = 4.0;
  const auto model = find_model("sphere_flight");
  const std::vector<double> x = {0.0, 0.0, 0.0, speed, 0.0, 0.0, 60.0, 0.0, 80.0};
  const auto drag = [&](const Values& values) {
    std::vector<Wrench> terms(4);
    model->forces(0.0, x, parameter_values(*model, values), terms);
    return terms[0].force;
  };
  const Eigen::Vector3d plain = drag({{"C_D", 0.55}});
  CHECK((drag({{"C_D", 0.45}, {"spin_drag", 0.2}}) - plain).norm() < 1e-6 * plain.norm());
}

TEST_CASE("a ball at rest without spin has finite derivatives by everything") {
  for (const char* name : {"sphere_flight", "sphere_flight_turned_spin"}) {
    const auto model = find_model(name);
    const ParameterValues p = parameter_values(*model, {});
    std::vector<double> f(9);
    Eigen::MatrixXd df_dx(9, 9);
    Eigen::MatrixXd df_dp(9, static_cast<Eigen::Index>(p.value.size()));
    model->rhs_with_derivatives(0.0, std::vector<double>(9, 0.0), p, f, df_dx, df_dp);
    CHECK(df_dx.allFinite());
    CHECK(df_dp.allFinite());
  }
}

TEST_CASE("a spin given in turned axes acts as the turned spin in the world's") {
  std::mt19937 random(11);
  for (int k = 0; k < 5; ++k) {
    const Eigen::Vector3d turn = random_vector(random, 1.5);
    const Eigen::Vector3d v = random_vector(random, 6.0);
    const Eigen::Vector3d w = random_vector(random, 150.0);
    const Eigen::Vector3d in_world = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * w;
    Values values = {{"magnus_saturation", 1.3}, {"spin_decay", 0.5}};
    const Eigen::MatrixXd expected = flight(values, v, in_world, {0.3});
    values.insert({{"spin_frame_x", turn.x()}, {"spin_frame_y", turn.y()}, {"spin_frame_z", turn.z()}});
    const Eigen::MatrixXd turned = flight(values, v, w, {0.3}, "sphere_flight_turned_spin");
    CHECK((turned.leftCols(6) - expected.leftCols(6)).norm() < 1e-9 * expected.norm());
    CHECK((turned.rightCols(3).transpose() - std::exp(-0.15) * w).norm() < 1e-9 * w.norm());
  }
}
