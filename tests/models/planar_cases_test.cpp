// The linear-drag plate of Tanabe and Kaneko, (3.4)-(3.5), and the coupled triple of (6.22).
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <catch2/catch.hpp>

#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("the coupled triple of (6.22) meets the check values of the model sheet") {
  struct Row {
    std::array<double, 3> start, at_1;
  };
  const std::array rows = {
      Row{{0.0, 0.0, 0.0}, {-0.80642521, 2.06261437, 3.04404622}},
      Row{{1.0, 1.0, 1.0}, {-1.40040563, 2.68530823, 3.7079901}},
      Row{{0.5, 0.25, 0.75}, {-0.52434872, 1.64365809, 3.51532354}},
      Row{{1.0, 0.0, 0.5}, {2.07946533, -0.8527867, 3.4907975}},
  };
  const ParametricModel model(find_model("coupled_triple"), {}, {"u1(0)", "u2(0)", "u3(0)"});
  for (const Row& row : rows) {
    const Trajectory trajectory = integrate(model, row.start, std::array{1.0}, {.relative_tolerance = 1e-12});
    REQUIRE(trajectory.is_usable());
    for (std::size_t i = 0; i < 3; ++i) {
      // Eight decimals are stated. Errors grow along the way: at 1e-10 they are 3e-8.
      CHECK_THAT(trajectory.states(0, static_cast<Eigen::Index>(i)), WithinAbs(row.at_1[i], 1e-8));
    }
  }
}

namespace {

const std::map<std::string, double> kPaper = {{"chord", 0.1}, {"mass", 8e-3}, {"sign_floor", 1e-9}};

}  // namespace

TEST_CASE("the linear-drag plate has the rates of (3.4)-(3.5), with gravity and over the mass") {
  const auto model = find_model("falling_plate_linear_drag");
  const ParametricModel paper(model, kPaper, {});
  ParametricModel::Workspace workspace = paper.make_workspace();
  std::mt19937 random(2);
  std::uniform_real_distribution<double> symmetric(-2.0, 2.0);
  const double A_perp = 4.1, A_par = 0.9, chord = 0.1, mass = 8e-3, fluid = 1.23;
  for (int trial = 0; trial < 100; ++trial) {
    std::array<double, 6> x, rate;
    for (double& value : x) value = symmetric(random);
    const auto [u, v, w, theta, px, py] = x;
    const double s = std::sin(theta), c = std::cos(theta);
    const double alpha = std::atan2(u, v), beta = alpha + theta, V2 = u * u + v * v;
    const double k = std::copysign(1.0, v) * std::sin(beta) >= 0.0 ? 1.0 : -1.0;
    const double lift = k * std::numbers::pi * fluid * chord * V2 / mass * std::cos(beta);
    paper.rhs(0.0, x, {}, rate, workspace);
    const double size = 10.0 + V2 * std::numbers::pi * fluid * chord / mass + std::abs(A_perp * w);
    CHECK_THAT(rate[0], WithinAbs(-(A_perp * s * s + A_par * c * c) * u + (A_perp - A_par) * s * c * v -
                                      lift * std::cos(alpha),
                                  1e-12 * size));
    CHECK_THAT(rate[1], WithinAbs(-(A_perp * c * c + A_par * s * s) * v + (A_perp - A_par) * s * c * u +
                                      lift * std::sin(alpha) - 9.81,
                                  1e-12 * size));
    CHECK_THAT(rate[2], WithinRel(-A_perp * w - 3.0 * std::numbers::pi * fluid * V2 / mass * std::cos(beta) *
                                                    std::sin(beta),
                                  1e-9));
    CHECK(rate[3] == w);
    CHECK(rate[4] == u);
    CHECK(rate[5] == v);
  }
}

TEST_CASE("held broadside, the linear-drag plate falls from rest as -g/A (1 - exp(-A t))") {
  auto fixed = kPaper;
  fixed["theta(0)"] = 0.0;
  const ParametricModel paper(find_model("falling_plate_linear_drag"), fixed, {});
  const Trajectory trajectory = integrate(paper, {}, std::array{0.1, 0.5, 1.0});
  REQUIRE(trajectory.is_usable());
  for (Eigen::Index row = 0; row < 3; ++row) {
    CHECK_THAT(trajectory.states(row, 1),
               WithinRel(-9.81 / 4.1 * (1.0 - std::exp(-4.1 * trajectory.times[row])), 1e-8));
    CHECK(trajectory.states(row, 3) == 0.0);
  }
}

TEST_CASE("the drag of the linear-drag plate takes power, its lift does none, all add up") {
  const auto model = find_model("falling_plate_linear_drag");
  const ParametricModel paper(model, kPaper, {});
  const ParameterValues p = {paper.parameters({}),
                             std::vector<char>(paper.model().info().parameters.size(), 1)};
  std::mt19937 random(4);
  std::uniform_real_distribution<double> symmetric(-2.0, 2.0);
  for (int trial = 0; trial < 200; ++trial) {
    std::array<double, 6> x, rate;
    for (double& value : x) value = symmetric(random);
    std::array<Wrench, 6> terms;
    model->forces(0.0, x, p, terms);
    model->rhs(0.0, x, p, rate);
    double sum = 0.0, size = 0.0;
    for (const Wrench& wrench : terms) {
      sum += wrench.power;
      size += wrench.force.norm() * 3.0 + wrench.torque.norm() * 2.0;
    }
    CHECK_THAT(terms[0].power, WithinAbs(0.0, 1e-14 * size));
    CHECK(terms[1].power <= 0.0);
    CHECK_THAT(terms[2].power, WithinAbs(0.0, 1e-14 * size));
    CHECK(terms[4].power <= 0.0);
    const double inertia = 8e-3 * 0.01 / 12.0;
    const double rate_of_energy = 8e-3 * (x[0] * rate[0] + x[1] * rate[1]) + inertia * x[2] * rate[2];
    CHECK_THAT(sum, WithinAbs(rate_of_energy, 1e-13 * size));
  }
}
