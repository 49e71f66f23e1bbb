// The wake and the separation of wakes/wake.h, against Wagner's function, measured curves and the laws without them.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <catch2/catch.hpp>

#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;

namespace {

constexpr double kHalfCircle = std::numbers::pi;
constexpr double kChord = 0.02, kWater = 998.2;

const std::map<std::string, double> kAluminium = {
    {"semi_chord", 0.5 * kChord}, {"semi_thickness", 7e-4}, {"density", 2700.0}};
/// Li, Goodwill, Wang and Ristroph (2022), as wake.h has them.
const std::map<std::string, double> kMeasured = {
    {"C_T", 0.95}, {"C_R", 1.1},   {"A", 1.0},           {"B", 0.9},        {"C_TA", 1.65},
    {"C_DA", 3.1}, {"kappa", 0.0}, {"cp_attached", 0.3}, {"cp_slope", 3.0}, {"cp_separated", 0.25}};

std::map<std::string, double> with(std::map<std::string, double> values,
                                   const std::map<std::string, double>& more) {
  for (const auto& [name, value] : more) values[name] = value;
  return values;
}

ParameterValues values_of(const ParametricModel& model) {
  return {model.parameters({}), std::vector<char>(model.model().info().parameters.size(), 1)};
}

std::vector<double> rates(const ParametricModel& model, const std::vector<double>& x) {
  std::vector<double> f(x.size());
  model.model().rhs(0.0, x, values_of(model), f);
  return f;
}

Wrench term(const ParametricModel& model, const std::vector<double>& x, std::string_view name) {
  const auto& terms = model.model().info().force_terms;
  std::vector<Wrench> wrenches(terms.size());
  model.model().forces(0.0, x, values_of(model), wrenches);
  const auto found = std::ranges::find(terms, name, &ForceTermInfo::name);
  return wrenches[static_cast<std::size_t>(found - terms.begin())];
}

/// Speeds of about 0.3 m/s, rates of 10 rad/s.
std::vector<double> random_plate(std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  return {0.3 * u(random), 0.3 * u(random), 10.0 * u(random), 3.0 * u(random),
          u(random),       u(random),       0.2 * u(random),  0.2 * u(random)};
}

/// R. T. Jones' approximation of Wagner's function. @param s semi-chords travelled
double wagner(double s) {
  return 1.0 - 0.165 * std::exp(-0.0455 * s) - 0.335 * std::exp(-0.3 * s);
}

/// Largest difference from Wagner's function of the answer to a jump of attitude, over the jump.
/// @param answer the bound circulation over its last value, after so many seconds
template <class Answer>
double distance_from_wagner(double speed, const Answer& answer) {
  double largest = 0.0;
  for (double s = 0.0; s < 100.0; s += 0.5)
    largest = std::max(largest, std::abs(answer(0.5 * s * kChord / speed) - wagner(s)));
  return largest;
}

}  // namespace

TEST_CASE("without memory the plate with a wake is the plate, whatever the wake holds") {
  const ParametricModel plate(find_model("falling_plate"), kAluminium, {});
  const ParametricModel with_wake(find_model("falling_plate_with_wake"),
                                  with(kAluminium, {{"memory_T", 0.0}, {"memory_R", 0.0}}), {});
  std::mt19937 random(1);
  for (int k = 0; k < 50; ++k) {
    const std::vector<double> x = random_plate(random);
    const std::vector<double> expected = rates(plate, {x.begin(), x.begin() + 6});
    const std::vector<double> f = rates(with_wake, x);
    // Sums of a dozen products, of rates of up to 1e3: round-off.
    for (std::size_t i = 0; i < 6; ++i) CHECK_THAT(f[i], WithinAbs(expected[i], 1e-11));
  }
}

TEST_CASE("the fall of a plate tends to the quasi-steady one in proportion to the lag") {
  const std::array times = {0.1, 0.2, 0.4};
  const Trajectory limit = integrate(ParametricModel(find_model("falling_plate"), kAluminium, {}), {}, times);
  const auto difference = [&](double lag) {
    const ParametricModel model(find_model("falling_plate_with_wake"),
                                with(kAluminium, {{"lag_T", lag}, {"lag_R", lag}}), {});
    const Trajectory fall = integrate(model, {}, times);
    REQUIRE(fall.is_usable());
    return Eigen::MatrixXd(fall.states.leftCols(6) - limit.states);
  };
  const Eigen::MatrixXd at_2 = difference(2e-3), at_1 = difference(1e-3);
  // First order: the second one is about a hundredth of the first at a lag of 1e-3 chords.
  CHECK((at_2 - 2.0 * at_1).norm() < 0.05 * at_2.norm());
  CHECK(at_1.norm() > 1e-5);
}

TEST_CASE("a plate that is tilted at once gets the circulation that Wagner says") {
  const ParametricModel plate(find_model("falling_plate_with_wake"), kAluminium, {});
  const double vx = 0.4, vy = -0.02;
  const double speed = std::hypot(vx, vy);
  const auto lift_at = [&](double circulation) {
    return term(plate, {vx, vy, 0.0, 0.0, 0.0, 0.0, circulation, 0.0}, "translational lift").force.y();
  };
  // Linear in what is remembered: its rate gives where it goes to, and how fast.
  const double at_rest = rates(plate, {vx, vy, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0})[6];
  const double slope = rates(plate, {vx, vy, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0})[6] - at_rest;
  const double last = -at_rest / slope;
  const double distance = distance_from_wagner(
      speed, [&](double t) { return lift_at(last * (1.0 - std::exp(slope * t))) / lift_at(last); });
  CHECK(distance < 0.0425);
  CHECK(distance > 0.03);  // of one exponential
  CHECK_THAT(lift_at(0.0) / lift_at(last), WithinAbs(0.5, 1e-12));
  // The rotational circulation likewise: C_R a w per chord in the end.
  const std::vector<double> turning = rates(plate, {vx, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0});
  CHECK_THAT(turning[7] / (kHalfCircle * 0.5 * kChord * 3.0), WithinAbs(vx / (kChord * 3.4), 1e-6));
}

TEST_CASE("lift, drag and centre of pressure are those measured of plates that glide") {
  const ParametricModel plate(find_model("falling_plate_with_wake"),
                              with(with(kAluminium, kMeasured), {{"memory_T", 0.0}}), {});
  const double speed = 0.3;
  const double pressure = 0.5 * kWater * kChord * speed * speed;
  std::array<double, 3> largest = {};
  for (double degrees = 0.5; degrees < 90.0; degrees += 0.5) {
    const double alpha = degrees * kHalfCircle / 180.0;
    const double sine = std::sin(alpha), cosine = std::cos(alpha);
    const std::vector<double> x = {speed * cosine, -speed * sine, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    const Wrench lift = term(plate, x, "translational lift"), drag = term(plate, x, "drag");
    // H. Li et al., J. Fluid Mech. 937 (2022) A6.
    const double attached = 0.5 * (1.0 - std::tanh((degrees - 14.0) / 6.0));
    const double C_L = attached * 5.2 * sine + (1.0 - attached) * 0.95 * std::sin(2.0 * alpha);
    const double C_D = attached * (0.1 + 5.0 * sine * sine) + (1.0 - attached) * 1.9 * sine * sine;
    const double centre =
        attached * (0.3 - 3.0 * alpha * alpha) + (1.0 - attached) * 0.3 * (1.0 - alpha / (0.5 * kHalfCircle));
    const double offset = (lift.torque.z() + drag.torque.z()) / (lift.force.y() + drag.force.y()) / kChord;
    largest[0] = std::max(largest[0], std::abs(lift.force.norm() / pressure - C_L));
    largest[1] = std::max(largest[1], std::abs(drag.force.norm() / pressure - C_D));
    largest[2] = std::max(largest[2], std::abs(offset - centre));
    CHECK(lift.force.y() > 0.0);
  }
  CHECK(largest[0] < 0.09);
  CHECK(largest[1] < 0.12);
  CHECK(largest[2] < 0.0225);
}

TEST_CASE("a falling plate with a wake never gains energy, with the centre of pressure off its middle") {
  const std::map<std::string, double> passive = with(with(kAluminium, kMeasured), {{"kappa", 1.0}});
  const ParametricModel plate(find_model("falling_plate_with_wake"), passive, {});
  std::vector<double> times;
  for (int k = 0; k <= 200; ++k) times.push_back(5e-3 * k);
  const Trajectory fall = integrate(plate, {}, times);
  REQUIRE(fall.is_usable());
  const double weight = kHalfCircle * 0.5 * kChord * 7e-4 * (2700.0 - kWater) * 9.81;
  double before = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < fall.states.rows(); ++k) {
    const Eigen::VectorXd x = fall.states.row(k);
    const std::vector<double> state(x.data(), x.data() + x.size());
    const double energy = *plate.model().kinetic_energy(0.0, state, values_of(plate)) + weight * x[5];
    CHECK(energy <= before + 1e-9 * weight * kChord);
    before = energy;
  }
}

TEST_CASE("half a turn of the plate leaves its wake as it is, its mirror image turns it round") {
  const ParametricModel plate(find_model("falling_plate_with_wake"), with(kAluminium, kMeasured), {});
  const std::array<double, 8> turn = {-1, -1, 1, 1, 1, 1, 1, 1}, mirror = {-1, 1, -1, -1, -1, 1, -1, -1};
  std::mt19937 random(3);
  for (const bool is_turn : {true, false}) {
    const auto& signs = is_turn ? turn : mirror;
    for (int k = 0; k < 20; ++k) {
      const std::vector<double> x = random_plate(random);
      std::vector<double> image = x;
      for (std::size_t i = 0; i < 8; ++i) image[i] *= signs[i];
      if (is_turn) image[3] += kHalfCircle;
      const std::vector<double> f = rates(plate, x), of_image = rates(plate, image);
      for (std::size_t i = 0; i < 8; ++i) CHECK_THAT(of_image[i], WithinAbs(signs[i] * f[i], 1e-9));
    }
  }
}
