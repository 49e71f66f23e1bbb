#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "accuracy.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kG = 9.81;

double terminal_speed(double C_D) {
  return std::sqrt(2.0 * 0.1 * kG / (1.23 * C_D * 0.5));
}

/// The exact fall from rest.
double exact(double C_D, double t) {
  return -terminal_speed(C_D) * std::tanh(kG * t / terminal_speed(C_D));
}

}  // namespace

TEST_CASE("the fall of (6.20) from rest follows the exact tanh") {
  const ParametricModel model(find_model("quadratic_drag_fall"), {}, {"C_D"});
  std::vector<double> times;
  for (int k = 0; k <= 40; ++k) times.push_back(0.025 * k);
  for (const double C_D : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    const Trajectory trajectory = integrate(model, std::array{C_D}, times);
    REQUIRE(trajectory.is_usable());
    const double bound = promised(trajectory, 1e-10, terminal_speed(C_D));
    for (Eigen::Index row = 0; row < trajectory.times.size(); ++row) {
      CHECK_THAT(trajectory.states(row, 0), WithinAbs(exact(C_D, trajectory.times[row]), bound));
    }
  }
}

TEST_CASE("the fall of (6.20) meets the check values of the model sheet") {
  // Model sheet, section 10: u(0.1) and u(0.5), sixteen digits.
  struct Row {
    double C_D, terminal, at_01, at_05;
  };
  const std::array rows = {
      Row{0.5, 2.525962748117646, -0.9344834120337976, -2.4241138219930614},
      Row{1.0, 1.7861253882185943, -0.8929654528555782, -1.7714744288532893},
      Row{2.0, 1.262981374058823, -0.8219834481955962, -1.2619124860598625},
  };
  const ParametricModel model(find_model("quadratic_drag_fall"), {}, {"C_D"});
  for (const Row& row : rows) {
    CHECK_THAT(terminal_speed(row.C_D), WithinRel(row.terminal, 1e-14));
    CHECK_THAT(model.scales(std::array{row.C_D}).velocity, WithinRel(row.terminal, 1e-14));
    const Trajectory trajectory = integrate(model, std::array{row.C_D}, std::array{0.1, 0.5});
    const double bound = promised(trajectory, 1e-10, row.terminal);
    CHECK_THAT(trajectory.states(0, 0), WithinAbs(row.at_01, bound));
    CHECK_THAT(trajectory.states(1, 0), WithinAbs(row.at_05, bound));
  }
}

TEST_CASE("drag opposes the motion both ways") {
  const ParametricModel model(find_model("quadratic_drag_fall"), {{"C_D", 1.0}, {"g", 0.0}}, {});
  ParametricModel::Workspace workspace = model.make_workspace();
  std::vector<double> rate(1);
  const double k = 1.23 * 1.0 * 0.5 / (2.0 * 0.1);
  for (const double u : {-3.0, -1e-9, 0.0, 1e-9, 3.0}) {
    model.rhs(0.0, std::array{u}, {}, rate, workspace);
    CHECK_THAT(rate[0], WithinRel(-k * std::abs(u) * u, 1e-15));
  }
}
