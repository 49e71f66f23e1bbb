/// Models whose parameters change in time.
#include "samara/models/interface/following_model.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/models/batch/rk4_frames.h"
#include "samara/models/checks/check_model.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// value(t) = first + slope t, both of them parameters.
class Straight final : public ParameterCourse {
 public:
  explicit Straight(std::vector<std::string> followed) : followed_(std::move(followed)) {}

  const std::vector<std::string>& followed() const override { return followed_; }
  std::vector<ParameterInfo> parameters() const override {
    return {{.name = "first", .unit = "1", .description = "at time 0"},
            {.name = "slope", .unit = "1", .description = "in time"}};
  }
  void values(double t, std::span<const double> own, std::span<double> followed) const override {
    for (double& value : followed) value = own[0] + own[1] * t;
  }
  void derivatives(double t, std::span<const double>, Eigen::Ref<Eigen::MatrixXd> by_own) const override {
    by_own.col(0).setOnes();
    by_own.col(1).setConstant(t);
  }

 private:
  std::vector<std::string> followed_;
};

std::shared_ptr<const Model> straight(const std::string& model, std::vector<std::string> followed) {
  return following(find_model(model), std::make_shared<Straight>(std::move(followed)));
}

}  // namespace

TEST_CASE("a rate that grows in time is integrated as such, with its sensitivities") {
  // u' = (first + slope t)/k - 1: u = (first t + slope t^2/2)/k - t.
  const ParametricModel model(straight("constant_rate", {"rate"}), {{"k", 2.0}}, {"first", "slope"});
  const std::vector<double> times = {0.0, 0.5, 3.0};
  const auto trajectory = integrate(model, std::vector{3.0, 4.0}, times);
  Rk4Frames frames(model, times, {.step = 0.5, .states = {0}, .directions = {0, 1}});
  Eigen::MatrixXd values(3, 1), derivatives(3, 2);
  REQUIRE(frames(std::vector{3.0, 4.0}, values, &derivatives));
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double t = times[static_cast<std::size_t>(k)];
    const double exact = (3.0 * t + 2.0 * t * t) / 2.0 - t;
    // The integrator's tolerance; Runge-Kutta is exact for a rate that is linear in time.
    CHECK_THAT(trajectory.states(k, 0), WithinAbs(exact, 1e-8));
    CHECK_THAT(values(k, 0), WithinAbs(exact, 1e-13));
    CHECK_THAT(derivatives(k, 0), WithinAbs(t / 2.0, 1e-13));
    CHECK_THAT(derivatives(k, 1), WithinAbs(t * t / 4.0, 1e-13));
  }
}

TEST_CASE("a model with a course passes the checks of a model") {
  const auto check = check_model(*straight("falling_plate_nd", {"C_R"}), {.units = false});
  INFO((check.findings.empty() ? std::string() : check.findings.front()));
  CHECK(check.passed());
}

TEST_CASE("a default that depends on what follows follows too, in every integrator") {
  // mu2 is mu1 where it is not given: nothing but the course can tell the two models apart.
  const std::map<std::string, double> fixed = {
      {"inertia_ratio", 1.1}, {"beta", 1.0 / 14.0}, {"theta(0)", 0.3}, {"first", 0.1}, {"slope", 0.02}};
  const ParametricModel alone(straight("falling_plate_nd", {"mu1"}), fixed, {});
  const ParametricModel both(straight("falling_plate_nd", {"mu1", "mu2"}), fixed, {});
  const std::vector<double> times = {0.0, 2.0, 4.0};
  const auto a = integrate(alone, {}, times), b = integrate(both, {}, times);
  CHECK_THAT((a.states - b.states).cwiseAbs().maxCoeff(), WithinAbs(0.0, 1e-12));
  Rk4Frames rk4(alone, times, {.step = 0.01, .states = {0, 1, 2, 3}, .directions = {}});
  Eigen::MatrixXd values(3, 4);
  REQUIRE(rk4({}, values, nullptr));
  CHECK_THAT((values - a.states.leftCols(4)).cwiseAbs().maxCoeff(), WithinAbs(0.0, 1e-5));
}

TEST_CASE("a course of what is no parameter is refused") {
  CHECK_THROWS_WITH(straight("falling_plate_nd", {"C_r"}),
                    Catch::Contains("no parameter \"C_r\"") && Catch::Contains("did you mean"));
  CHECK_THROWS_AS(straight("falling_plate_nd", {"C_R", "C_R"}), samara::ArgumentError);
}
