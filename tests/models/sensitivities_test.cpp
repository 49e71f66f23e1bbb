#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "accuracy.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"
#include "scalar_model.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;

namespace {

/// Of one trajectory, per free coordinate: the largest deviation of d(states)/dq_j from central differences
/// of trajectories at tolerance 1e-12 over a step h = 1e-4 q_j (1e-4 scale for an initial value), times q_j
/// over scale.
void check_against_differences(const ParametricModel& model, const std::vector<double>& q, bool stiff) {
  const std::vector<double> times = {0.05, 0.15, 0.3, 0.5};
  const IntegrateOptions options = {.stiff = stiff};
  // The tightest tolerance is for Adams alone: BDF, of order 5 at most, would take very many steps.
  const IntegrateOptions tight = {.relative_tolerance = 1e-12};
  const Trajectory trajectory = integrate(model, q, times, options, true);
  REQUIRE(trajectory.is_usable());
  REQUIRE(trajectory.sensitivities.size() == q.size());
  const Scales scales = model.scales(q);
  const Eigen::RowVector2d state_scales(scales.velocity, scales.length);
  Integrator reference(model, tight, false);
  for (std::size_t j = 0; j < q.size(); ++j) {
    const FreeCoordinate& coordinate = model.free()[j];
    const double size = coordinate.is_initial ? state_scales[coordinate.index] : q[j];
    const double h = 1e-4 * size;
    std::vector<double> above = q;
    std::vector<double> below = q;
    above[j] += h;
    below[j] -= h;
    const Trajectory up = reference(above, times);
    const Trajectory down = reference(below, times);
    const Eigen::MatrixXd difference = (up.states - down.states) / (above[j] - below[j]);
    const Eigen::MatrixXd deviation =
        (trajectory.sensitivities[j] - difference) * state_scales.cwiseInverse().asDiagonal() * size;
    // In units of the scales: truncation (1e-4)^2 times third derivatives of a few tens, integrations at
    // 1e-12 and a hundred steps over 1e-4, and the sensitivities' own error of hundred steps times 1e-10:
    // below 1e-6 together.
    INFO(coordinate.name << ", stiff " << stiff);
    CHECK(deviation.cwiseAbs().maxCoeff() < 2e-6);
    CHECK((difference * size * state_scales.cwiseInverse().asDiagonal()).cwiseAbs().maxCoeff() > 1e-3);
  }
}

}  // namespace

TEST_CASE("sensitivities of the fall of (6.20) are the derivatives of the exact solution") {
  const ParametricModel model(find_model("quadratic_drag_fall"), {}, {"C_D", "g", "u(0)", "mass"});
  const double g = 9.81;
  const std::vector<double> times = {0.0, 0.02, 0.1, 0.3, 0.8};
  for (const bool stiff : {false, true}) {
    for (const double C_D : {0.5, 1.0, 2.0}) {
      const Trajectory trajectory =
          integrate(model, std::vector<double>{C_D, g, 0.0, 0.1}, times, {.stiff = stiff}, true);
      REQUIRE(trajectory.is_usable());
      const double u_T = std::sqrt(2.0 * 0.1 * g / (1.23 * C_D * 0.5));
      for (Eigen::Index row = 0; row < trajectory.times.size(); ++row) {
        // u = -u_T tanh s with s = g t/u_T, so du/du_T = -tanh s + s sech^2 s; u_T ~ (mass g/C_D)^(1/2), and
        // s' = -2 k |u| s for the initial value gives sech^2 s.
        const double t = trajectory.times[row];
        const double s = g * t / u_T;
        const double sech2 = 1.0 / (std::cosh(s) * std::cosh(s));
        const double by_terminal = -std::tanh(s) + s * sech2;
        const std::array exact = {by_terminal * -u_T / (2.0 * C_D), by_terminal * u_T / (2.0 * g) - t * sech2,
                                  sech2, by_terminal * u_T / (2.0 * 0.1)};
        const std::array size = {C_D, g, u_T, 0.1};
        for (std::size_t j = 0; j < exact.size(); ++j) {
          INFO(model.free()[j].name << " at " << t);
          // Error control weighs q_j du/dq_j like u, over the scale u_T.
          CHECK_THAT(trajectory.sensitivities[j](row, 0) * size[j],
                     WithinAbs(exact[j] * size[j], promised(trajectory, 1e-10, u_T)));
        }
      }
    }
  }
}

TEST_CASE("sensitivities of the vertical fall agree with differences of tight integrations") {
  const std::map<std::string, double> fixed = {{"thickness", 2.55e-3}};
  const ParametricModel model(find_model("vertical_fall"), fixed,
                              {"C_D", "v(0)", "density", "area", "fluid_density"});
  for (const bool stiff : {false, true}) {
    check_against_differences(model, {1.15, 0.05, 6339.0, 4.714e-4, 998.2}, stiff);
    SECTION("also through a turn, where the second derivative of |v| v jumps") {
      check_against_differences(model, {1.15, -0.6, 6339.0, 4.714e-4, 998.2}, stiff);
    }
    SECTION("also for a body that rises") {
      check_against_differences(model, {0.8, 0.1, 300.0, 1e-3, 998.2}, stiff);
    }
  }
}

TEST_CASE("asking for sensitivities leaves the states as accurate as they were") {
  const ParametricModel model(find_model("vertical_fall"), {{"area", 4.714e-4}, {"thickness", 2.55e-3}},
                              {"C_D", "v(0)", "density"});
  const std::vector<double> q = {1.15, 0.0, 6339.0};
  const std::vector<double> times = {0.1, 0.3, 0.5};
  const Trajectory plain = integrate(model, q, times);
  const Trajectory rich = integrate(model, q, times, {}, true);
  CHECK((plain.states - rich.states).cwiseAbs().maxCoeff() <
        promised(plain, 1e-10, 1.0) + promised(rich, 1e-10, 1.0));
  // An analytic right-hand side lets tolerances be tight: no stall.
  CHECK(rich.steps < 3 * plain.steps);
}

TEST_CASE("a parameter at zero has a sensitivity like any other") {
  // x' = -x + p t at p = 0: dx/dp = t - 1 + exp(-t), whatever p.
  const auto law = std::make_shared<ScalarModel>([](double t, double x, double p) { return -x + p * t; },
                                                 [](double, double, double) { return -1.0; },
                                                 [](double t, double, double) { return t; });
  // The state stays near zero and asks for no small steps: the tolerance of the sensitivity alone must do it.
  const ParametricModel model(law, {}, {"p"});
  for (const double p : {0.0, 1e-9}) {
    const Trajectory trajectory = integrate(model, std::array{p}, std::array{0.5, 2.0}, {}, true);
    REQUIRE(trajectory.is_usable());
    for (Eigen::Index row = 0; row < 2; ++row) {
      const double t = trajectory.times[row];
      CHECK_THAT(trajectory.sensitivities[0](row, 0),
                 WithinAbs(t - 1.0 + std::exp(-t), promised(trajectory, 1e-10, 1.0)));
    }
  }
}

TEST_CASE("a derivative that is not finite ends with a status, and harms no later call") {
  // x' = sqrt(p) has no derivative by p at p = 0; x itself is fine there.
  const auto law = std::make_shared<ScalarModel>([](double, double, double p) { return std::sqrt(p); },
                                                 [](double, double, double) { return 0.0; },
                                                 [](double, double, double p) { return 0.5 / std::sqrt(p); });
  const ParametricModel model(law, {}, {"p"});
  for (const bool stiff : {false, true}) {
    Integrator integrator(model, {.stiff = stiff}, true);
    CHECK(integrator(std::array{0.0}, std::array{1.0}).status == IntegrateStatus::not_finite);
    // Starts from the same point, with another p.
    const Trajectory after = integrator(std::array{4.0}, std::array{1.0});
    REQUIRE(after.is_usable());
    CHECK_THAT(after.states(0, 0), WithinAbs(2.0, promised(after, 1e-10, 2.0)));
    CHECK_THAT(after.sensitivities[0](0, 0), WithinAbs(0.25, promised(after, 1e-10, 1.0)));
    CHECK(integrate(model, std::array{0.0}, std::array{1.0}, {.stiff = stiff}).is_usable());
  }
}

TEST_CASE("sensitivities of a model without free coordinates are none") {
  const ParametricModel model(find_model("constant_rate"), {{"k", 2.0}}, {});
  const Trajectory trajectory = integrate(model, {}, std::array{1.0}, {}, true);
  CHECK(trajectory.is_usable());
  CHECK(trajectory.sensitivities.empty());
}
