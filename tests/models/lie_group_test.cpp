#include "samara/models/integrators/lie_group.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "kirchhoff_ellipsoid.h"
#include "samara/base/errors.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

namespace {

BodyMotion moving_ones() {
  BodyMotion motion;
  motion.v_WB_B.setOnes();
  motion.w_WB_B.setOnes();
  return motion;
}

/// A body without symmetry: translation and rotation are coupled.
Matrix6 coupled_inertia() {
  Matrix6 shear = Matrix6::Identity();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < i; ++j) shear(i, j) = 0.1 * std::sin(1.0 + 3.0 * i + 7.0 * j);
  }
  return shear * ellipsoid_421_inertia() * shear.transpose();
}

double angle_between(const BodyMotion& a, const BodyMotion& b) {
  return (a.R_WB() - b.R_WB()).norm() / std::sqrt(2.0);
}

double velocity_difference(const BodyMotion& a, const BodyMotion& b) {
  return (a.v_WB_B - b.v_WB_B).norm() + (a.w_WB_B - b.w_WB_B).norm();
}

/// A pendulum-like wrench that depends on time, attitude, position and velocity.
Wrench some_wrench(double t, const BodyMotion& motion) {
  const Eigen::Vector3d down = motion.R_WB().transpose() * Eigen::Vector3d(0.0, 0.0, -40.0 * std::cos(t));
  Wrench wrench;
  wrench.force = down - 3.0 * motion.v_WB_B - motion.R_WB().transpose() * motion.p_WoBo_W;
  wrench.torque = Eigen::Vector3d(0.2, 0.1, 0.5).cross(down) - 10.0 * motion.w_WB_B;
  return wrench;
}

/// Observed order of the motion at t = 1 from three steps.
double observed_order(const Matrix6& inertia, int order, const BodyWrench& wrench, double h) {
  std::vector<BodyMotion> end;
  for (const double step : {h, h / 2.0, h / 4.0}) {
    const LieGroupIntegrator integrator(inertia, {.step = step, .order = order}, wrench);
    end.push_back(integrator(moving_ones(), std::array{1.0}).motions.at(0));
  }
  const auto distance = [](const BodyMotion& a, const BodyMotion& b) {
    return velocity_difference(a, b) + angle_between(a, b) + (a.p_WoBo_W - b.p_WoBo_W).norm();
  };
  return std::log2(distance(end[0], end[1]) / distance(end[1], end[2]));
}

}  // namespace

TEST_CASE("the Lie-group integrator has the order asked for, with and without forces") {
  for (const Matrix6& inertia : {ellipsoid_421_inertia(), coupled_inertia()}) {
    // Odd terms of the error are absent in a symmetric method: the order shows to about h^2.
    CHECK_THAT(observed_order(inertia, 2, {}, 0.05), WithinAbs(2.0, 0.1));
    CHECK_THAT(observed_order(inertia, 2, some_wrench, 0.05), WithinAbs(2.0, 0.1));
    CHECK_THAT(observed_order(inertia, 4, {}, 0.1), WithinAbs(4.0, 0.2));
    CHECK_THAT(observed_order(inertia, 4, some_wrench, 0.1), WithinAbs(4.0, 0.2));
  }
}

TEST_CASE("the Lie-group integrator reaches the states of the Kirchhoff check problem") {
  const LieGroupIntegrator integrator(ellipsoid_421_inertia(), {.step = 2.5e-3, .order = 4});
  const BodyTrajectory trajectory = integrator(moving_ones(), std::array{1.0, 10.0});
  REQUIRE(trajectory.is_usable());
  const auto check = [](const BodyMotion& motion, const Eigen::Vector3d& u, const Eigen::Vector3d& w) {
    CHECK((motion.v_WB_B - u).lpNorm<Eigen::Infinity>() < 1e-7);
    CHECK((motion.w_WB_B - w).lpNorm<Eigen::Infinity>() < 1e-7);
  };
  check(trajectory.motions[0], {-0.02619392, 1.86850287, 0.45549713}, {0.81178935, 1.34751761, -0.1018983});
  check(trajectory.motions[1], {-1.00957568, 1.30092497, 0.81928126}, {-0.61312995, 1.23152154, 0.70891937});
}

TEST_CASE(
    "over 1e5 steps without forces energy and momentum do not drift, and the attitude stays a rotation") {
  constexpr long kSteps = 100000;
  constexpr double kStep = 0.01;
  std::vector<double> times;
  for (long k = 0; k <= kSteps; k += 100) times.push_back(kStep * static_cast<double>(k));
  const LieGroupIntegrator integrator(ellipsoid_421_inertia(), {.step = kStep});
  const BodyTrajectory trajectory = integrator(moving_ones(), times);
  REQUIRE(trajectory.is_usable());
  CHECK(trajectory.steps == kSteps);

  const BodyMotion& start = trajectory.motions.front();
  const Eigen::Vector3d impulse = integrator.world_impulse(start);
  const Eigen::Vector3d angular = integrator.world_angular_impulse(start);
  CHECK_THAT(integrator.kinetic_energy(start), WithinRel(488.3032020440, 1e-12));
  CHECK((impulse - Eigen::Vector3d(71.26206873, 80.36351955, 117.89136495)).norm() < 1e-7);
  CHECK((angular - Eigen::Vector3d(80.6324743, 338.91422437, 287.54275219)).norm() < 1e-7);

  // Each step rounds a few times by 1e-16: at most 1e-10 after 1e5 steps that all err one way. The distance
  // travelled, 1e3, multiplies the angular impulse.
  const auto count = static_cast<double>(times.size());
  double sum_e = 0.0, sum_te = 0.0, sum_tt = 0.0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const BodyMotion& motion = trajectory.motions[k];
    const double e = integrator.kinetic_energy(motion) / integrator.kinetic_energy(start) - 1.0;
    const double t = times[k] - 0.5 * times.back();
    sum_e += e / count;
    sum_te += t * e;
    sum_tt += t * t;
    if (std::abs(e) > 1e-10) FAIL_CHECK("energy off by " << e << " at t = " << times[k]);
  }
  CHECK(std::abs(sum_te / sum_tt * times.back()) < 1e-10);
  const BodyMotion& end = trajectory.motions.back();
  CHECK((integrator.world_impulse(end) - impulse).norm() < 1e-10 * impulse.norm());
  CHECK((integrator.world_angular_impulse(end) - angular).norm() <
        1e-10 * impulse.norm() * end.p_WoBo_W.norm());
  CHECK((end.R_WB().transpose() * end.R_WB() - Eigen::Matrix3d::Identity()).norm() < 1e-15 * 8);
}

TEST_CASE("energy and momentum are kept whatever the step, the order and the inertia") {
  for (const int order : {2, 4}) {
    for (const double step : {0.3, 0.1}) {
      const LieGroupIntegrator integrator(coupled_inertia(), {.step = step, .order = order});
      const BodyTrajectory trajectory = integrator(moving_ones(), std::array{0.0, 30.0});
      REQUIRE(trajectory.is_usable());
      const BodyMotion& start = trajectory.motions[0];
      const BodyMotion& end = trajectory.motions[1];
      CHECK_THAT(integrator.kinetic_energy(end), WithinRel(integrator.kinetic_energy(start), 1e-12));
      CHECK((integrator.world_impulse(end) - integrator.world_impulse(start)).norm() <
            1e-12 * integrator.world_impulse(start).norm());
      CHECK((integrator.world_angular_impulse(end) - integrator.world_angular_impulse(start)).norm() <
            1e-12 * integrator.world_impulse(start).norm() * (1.0 + end.p_WoBo_W.norm()));
    }
  }
}

TEST_CASE("a constant force in the world changes the impulse by itself times time") {
  const Eigen::Vector3d weight(0.0, 0.0, -50.0);
  const BodyWrench gravity = [&](double, const BodyMotion& motion) {
    return Wrench{.force = motion.R_WB().transpose() * weight};
  };
  const LieGroupIntegrator integrator(ellipsoid_421_inertia(), {.step = 0.02}, gravity);
  const BodyTrajectory trajectory = integrator(moving_ones(), std::array{0.0, 5.0});
  REQUIRE(trajectory.is_usable());
  const BodyMotion& start = trajectory.motions[0];
  const BodyMotion& end = trajectory.motions[1];
  const Eigen::Vector3d gained = integrator.world_impulse(end) - integrator.world_impulse(start);
  CHECK((gained - 5.0 * weight).norm() < 1e-11 * weight.norm());
  // The work is that along the chords of steps: second order in h.
  const double work = weight.dot(end.p_WoBo_W - start.p_WoBo_W);
  CHECK_THAT(integrator.kinetic_energy(end) - integrator.kinetic_energy(start), WithinRel(work, 1e-3));
}

TEST_CASE("a screw motion about a principal axis is exact at any step") {
  // A sphere-like inertia moves along a helix of constant twist when u and w are parallel.
  const Matrix6 inertia = Eigen::Matrix<double, 6, 1>(2.0, 2.0, 2.0, 0.8, 0.8, 0.8).asDiagonal();
  BodyMotion start;
  start.v_WB_B = {0.0, 0.0, 0.5};
  start.w_WB_B = {0.0, 0.0, 3.0};
  const LieGroupIntegrator integrator(inertia, {.step = 0.5});
  const BodyMotion end = integrator(start, std::array{2.0}).motions.at(0);
  CHECK((end.p_WoBo_W - Eigen::Vector3d(0.0, 0.0, 1.0)).norm() < 1e-14);
  CHECK_THAT(end.R_WB()(0, 0), WithinAbs(std::cos(6.0), 1e-14));
  CHECK_THAT(end.R_WB()(1, 0), WithinAbs(std::sin(6.0), 1e-14));
}

TEST_CASE("steps too long for the iteration end with a status, and so does an infinite wrench") {
  const LieGroupIntegrator far(ellipsoid_421_inertia(), {.step = 100.0});
  const BodyTrajectory lost = far(moving_ones(), std::array{100.0});
  CHECK(lost.status == IntegrateStatus::failed);
  CHECK(lost.motions.empty());
  CHECK_THAT(lost.message, Catch::StartsWith("stopped at t = 0 in 0 steps: the velocity half-way"));

  const LieGroupIntegrator burst(ellipsoid_421_inertia(), {}, [](double t, const BodyMotion&) {
    Wrench wrench;
    wrench.force.x() = t < 0.5 ? 1.0 : std::nan("");
    return wrench;
  });
  const BodyTrajectory trajectory = burst(moving_ones(), std::array{0.4, 1.0});
  CHECK(trajectory.status == IntegrateStatus::not_finite);
  CHECK(trajectory.reached == 0.4);
  CHECK(trajectory.motions.size() == 1);
}

TEST_CASE("the Lie-group integrator refuses inertias, starts and options without meaning") {
  const Matrix6 inertia = ellipsoid_421_inertia();
  Matrix6 skewed = inertia;
  skewed(0, 1) = 1.0;
  CHECK_THROWS_WITH(LieGroupIntegrator(skewed),
                    "the inertia has 0 at (1, 0) and 1 at (0, 1); a symmetric matrix was expected");
  CHECK_THROWS_WITH(LieGroupIntegrator(Matrix6(-inertia)), Catch::Contains("not positive definite"));
  CHECK_THROWS_WITH(LieGroupIntegrator(Eigen::Matrix3d::Identity()),
                    "the inertia is 3 x 3; 6 x 6 was expected");
  CHECK_THROWS_AS(LieGroupIntegrator(Matrix6(inertia * std::nan(""))), samara::ArgumentError);
  CHECK_THROWS_WITH(LieGroupIntegrator(inertia, {.order = 3}), "order is 3; 2 or 4 was expected");
  CHECK_THROWS_AS(LieGroupIntegrator(inertia, {.step = 0.0}), samara::ArgumentError);
  CHECK_THROWS_AS(LieGroupIntegrator(inertia, {.max_iterations = 0}), samara::ArgumentError);
  BodyMotion nowhere = moving_ones();
  nowhere.q_WB = {0.0, 0.0, 0.0, 0.0};
  CHECK_THROWS_AS(LieGroupIntegrator(inertia)(nowhere, std::array{1.0}), samara::ArgumentError);
  CHECK_THROWS_AS(LieGroupIntegrator(inertia)(moving_ones(), std::array{-1.0}), samara::ArgumentError);
}

TEST_CASE("steps beyond count stop the integrator on the group before the first") {
  for (const double step : {1e-20, 1e-300}) {
    const LieGroupIntegrator integrator(ellipsoid_421_inertia(), {.step = step});
    const BodyTrajectory trajectory = integrator(moving_ones(), std::array{1.0});
    CHECK(trajectory.status == IntegrateStatus::too_many_steps);
    CHECK(trajectory.motions.empty());
    CHECK(trajectory.steps == 0);
  }
}
