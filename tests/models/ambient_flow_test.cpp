#include "samara/models/laws/ambient_flow.h"

#include <limits>

#include <catch2/catch.hpp>

#include "bodies_in_flow.h"
#include "samara/base/errors.h"
#include "samara/models/checks/check_model.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

using Values = std::map<std::string, double>;

const Values kCard = {{"a", 0.035},   {"b", 0.02},   {"c", 1e-4},   {"density", 1200.0}, {"C_D90", 0.61},
                      {"C_D0", 0.05}, {"C_T", 1.81}, {"C_R", 1.21}, {"C_w", 2.0}};

/// Any linear flow w = w_0 + A x + B t.
class LinearFlow final : public AmbientFlow {
 public:
  LinearFlow(const Eigen::Vector3d& velocity, const Eigen::Matrix3d& gradient, const Eigen::Vector3d& rate)
      : sample_{.velocity = velocity, .gradient = gradient, .rate = rate} {}

  AmbientSample sample(double t, const Eigen::Vector3d& position) const override {
    AmbientSample here = sample_;
    here.velocity += sample_.gradient * position + sample_.rate * t;
    return here;
  }
  double length() const override { return 1.0; }

 private:
  AmbientSample sample_;
};

/// Waves: w = (sin(k z - f t), cos(k x), sin(k x) cos(k y)), scaled.
class Waves final : public AmbientFlow {
 public:
  AmbientSample sample(double t, const Eigen::Vector3d& position) const override {
    const double x = k * position.x(), y = k * position.y(), z = k * position.z() - f * t;
    AmbientSample here;
    here.velocity = {std::sin(z), std::cos(x), std::sin(x) * std::cos(y)};
    here.gradient << 0.0, 0.0, k * std::cos(z),  //
        -k * std::sin(x), 0.0, 0.0,              //
        k * std::cos(x) * std::cos(y), -k * std::sin(x) * std::sin(y), 0.0;
    here.rate = {-f * std::cos(z), 0.0, 0.0};
    return here;
  }
  double length() const override { return 1.0 / k; }

 private:
  double k = 3.0;
  double f = 2.0;
};

BodyState oblique_release() {
  BodyState start;
  start.q = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1.0, 0.4, 0.2).normalized());
  start.u = {0.05, 0.05, -0.1};
  start.w = {1.0, 2.0, 3.0};
  return start;
}

/// The same motion relative to a wind: velocity and wind added.
BodyState carried(BodyState state, const Eigen::Vector3d& wind) {
  state.u += state.R().transpose() * wind;
  return state;
}

/// The greatest distance of two bodies, position, attitude and rates, each over its size here.
double distance(const BodyState& a, const BodyState& b) {
  return std::max({(a.position - b.position).norm(), (a.R() - b.R()).norm(), (a.u - b.u).norm(),
                   (a.w - b.w).norm() / 30.0});
}

}  // namespace

TEST_CASE("a steady uniform wind carries the motion in still air along") {
  const Eigen::Vector3d wind(3.0, -2.0, 0.5);
  const std::vector<double> times = {0.05, 0.1, 0.2, 0.3};
  const BodyState start = oblique_release();
  const Eigen::MatrixXd still = motion(find_model("immersed_body"), kCard, start, times);
  Values values = kCard;
  values["wind_x"] = wind.x();
  values["wind_y"] = wind.y();
  values["wind_z"] = wind.z();
  const Eigen::MatrixXd by_parameters =
      motion(find_model("immersed_body_in_wind"), values, carried(start, wind), times);
  const Eigen::MatrixXd by_field = motion(
      immersed_body_in(std::make_shared<LinearFlow>(wind, Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero())),
      kCard, carried(start, wind), times);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    BodyState expected = carried(BodyState(still.row(row)), wind);
    expected.position += times[k] * wind;
    // Three integrations at 1e-12 per step, of some thousand steps, amplified by less than e^(15/s 0.3 s).
    CHECK(distance(BodyState(by_parameters.row(row)), expected) < 1e-7);
    CHECK(distance(BodyState(by_field.row(row)), expected) < 1e-7);
  }
}

TEST_CASE("the parameters of a linear wind and the same wind as a field are one model") {
  Values values = kCard;
  values["wind_x"] = 1.0;
  values["shear_x"] = 4.0;
  values["shear_y"] = -2.0;
  values["wind_z"] = 0.3;
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
  gradient(0, 2) = 4.0;
  gradient(1, 2) = -2.0;
  const auto by_parameters = find_model("immersed_body_in_wind");
  const auto by_field = immersed_body_in(
      std::make_shared<LinearFlow>(Eigen::Vector3d(1.0, 0.0, 0.3), gradient, Eigen::Vector3d::Zero()));
  const std::vector<double> x = oblique_release().vector();
  const ParameterValues p = parameter_values(*by_parameters, values);
  const ParameterValues q = parameter_values(*by_field, kCard);
  Eigen::VectorXd f(13), g(13);
  by_parameters->rhs(0.4, x, p, {f.data(), 13});
  by_field->rhs(0.4, x, q, {g.data(), 13});
  CHECK((f - g).norm() < 1e-14 * f.norm());
}

TEST_CASE(
    "in a flow that accelerates as a whole the motion relative to it is that under gravity less the "
    "acceleration") {
  // In the frame of a fluid that accelerates with A the fluid rests and gravity is g_w - A: the buoyancy of
  // the pressure gradient m_f A is part of it. With A = (0, 0, 2) this is g = 11.81 m/s^2.
  const double A = 2.0;
  const auto accelerated = immersed_body_in(std::make_shared<LinearFlow>(
      Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Vector3d(0.0, 0.0, A)));
  Values heavier = kCard;
  heavier["g"] = 9.81 + A;
  const std::vector<double> times = {0.1, 0.3};
  const BodyState start = oblique_release();
  const Eigen::MatrixXd in_flow = motion(accelerated, kCard, start, times);
  const Eigen::MatrixXd still = motion(find_model("immersed_body"), heavier, start, times);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const double t = times[k];
    BodyState expected = carried(BodyState(still.row(row)), Eigen::Vector3d(0.0, 0.0, A * t));
    expected.position.z() += 0.5 * A * t * t;
    CHECK(distance(BodyState(in_flow.row(row)), expected) < 1e-7);
  }
}

TEST_CASE("a neutrally buoyant body that goes with an accelerating fluid is carried by it") {
  // Density of the fluid, moving with it, no rotation: the pressure gradient alone gives it the acceleration.
  const auto model = immersed_body_in(std::make_shared<LinearFlow>(
      Eigen::Vector3d(0.2, 0.0, 0.0), Eigen::Matrix3d::Zero(), Eigen::Vector3d(0.7, -0.3, 0.1)));
  const Values values = {
      {"a", 0.05}, {"b", 0.03}, {"c", 0.01}, {"density", 1000.0}, {"fluid_density", 1000.0}};
  BodyState start;
  start.u = {0.2, 0.0, 0.0};
  const BodyState end(motion(model, values, start, {1.0}).row(0));
  CHECK((end.position - Eigen::Vector3d(0.2 + 0.35, -0.15, 0.05)).norm() < 1e-10);
  CHECK((end.u - Eigen::Vector3d(0.9, -0.3, 0.1)).norm() < 1e-10);
}

TEST_CASE("a body in a flow field passes the check of models") {
  const auto model = immersed_body_in(std::make_shared<Waves>());
  const samara::Check check = check_model(*model, {.seed = 4, .points = 100});
  for (const std::string& finding : check.findings) {
    // The waves are 1/3 m long and 1 m/s fast: they do not follow a change of units.
    if (finding.find("follow its unit") == std::string::npos) FAIL_CHECK(finding);
  }
  CHECK(model->info().symmetries.empty());
}

TEST_CASE("the powers of all terms sum to the rate of energy in an unsteady flow field too") {
  const Waves waves;
  const auto model = immersed_body_in(std::make_shared<Waves>());
  const ParameterValues p = parameter_values(*model, kCard);
  std::mt19937 random(9);
  for (int k = 0; k < 20; ++k) {
    BodyState state = oblique_release();
    state.position = random_vector(random, 1.0);
    const double t = 0.1 * k;
    std::vector<double> x = state.vector();
    Eigen::VectorXd f(13);
    model->rhs(t, x, p, {f.data(), 13});
    std::vector<Wrench> terms(model->info().force_terms.size());
    model->forces(t, x, p, terms);
    double power = 0.0;
    for (const Wrench& term : terms) power += term.power;
    const double h = 1e-6;
    const auto energy = [&](double way) {
      std::vector<double> moved = x;
      for (std::size_t i = 0; i < 13; ++i) moved[i] += way * f[static_cast<Eigen::Index>(i)];
      return *model->kinetic_energy(t + way, moved, p);
    };
    // Central differences over 1 us: truncation (30/s h)^2 and round-off 1e-16/(30/s h), below 1e-8 each.
    CHECK_THAT((energy(h) - energy(-h)) / (2.0 * h), WithinAbs(power, 1e-6 * std::abs(power) + 1e-9));
  }
}

TEST_CASE("a missing flow or one without a length is refused") {
  struct Flat final : AmbientFlow {
    AmbientSample sample(double, const Eigen::Vector3d&) const override { return {}; }
    double length() const override { return 0.0; }
  };
  CHECK_THROWS_WITH(immersed_body_in(nullptr), "there is no ambient flow; a flow field was expected");
  CHECK_THROWS_WITH(immersed_body_in(std::make_shared<Flat>()),
                    "the length of the ambient flow is 0; a positive finite number was expected");
}
