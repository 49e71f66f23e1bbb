// Model sheet, section 3: the plates of Andersen, Pesavento and Wang, by states, balances and limits.
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <catch2/catch.hpp>

#include "planar_references.h"
#include "samara/base/errors.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

using PlanarState = std::array<double, 6>;
enum { kVx, kVy, kOmega, kTheta, kX, kY };

constexpr double kHalfTurn = std::numbers::pi;

const std::vector<std::string> kPlates = {"falling_plate_nd", "falling_plate", "falling_rectangle"};

ParameterValues all_default(const Model& model) {
  const std::size_t n = model.info().parameters.size();
  return {std::vector<double>(n), std::vector<char>(n, 0)};
}

/// Everything given, as the model completes it.
ParameterValues all_given(const ParametricModel& model) {
  return {model.parameters({}), std::vector<char>(model.model().info().parameters.size(), 1)};
}

/// Parameters of their order of magnitude, everything given; a plate of metal in water where it has units.
ParameterValues random_parameters(const Model& model, std::mt19937& random) {
  std::uniform_real_distribution<double> factor(0.5, 2.0);
  std::uniform_real_distribution<double> symmetric(-0.4, 0.4);
  ParameterValues p;
  double chord = 0.0;
  for (const ParameterInfo& parameter : model.info().parameters) {
    double value = parameter.default_value.value_or(0.2) * factor(random);
    if (parameter.name == "semi_chord" || parameter.name == "chord") value = chord = 0.01 * factor(random);
    if (parameter.name == "semi_thickness" || parameter.name == "thickness") value = 0.1 * chord;
    if (parameter.name == "offset") value = symmetric(random) * chord;
    if (parameter.name == "density") value = 2700.0 * factor(random);
    if (parameter.name == "moment_of_inertia") value = 1e-6 * factor(random);
    if (parameter.name == "speed_floor") value = 1e-6;
    // Drag is passive where A >= |B|.
    if (parameter.name == "A") value = 2.0 * factor(random);
    if (parameter.name == "B") value = factor(random) - 1.0;
    p.value.push_back(value);
    p.given.push_back(1);
  }
  return p;
}

PlanarState random_state(const Model& model, const ParameterValues& p, std::mt19937& random) {
  std::uniform_real_distribution<double> symmetric(-3.0, 3.0);
  const Scales scales = model.scales(p);
  PlanarState x;
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = symmetric(random) * state_scale(model.info().states[i], scales);
  }
  return x;
}

std::size_t term(const Model& model, const std::string& name) {
  const auto& terms = model.info().force_terms;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    if (terms[k].name == name) return k;
  }
  throw samara::ArgumentError("no term " + name);
}

struct Breakdown {
  std::vector<Wrench> terms;
  Wrench sum;
  double largest_power = 0.0;
};

Breakdown break_down(const Model& model, const PlanarState& x, const ParameterValues& p) {
  Breakdown b;
  b.terms.resize(model.info().force_terms.size());
  model.forces(0.0, x, p, b.terms);
  for (const Wrench& wrench : b.terms) {
    b.sum.force += wrench.force;
    b.sum.torque += wrench.torque;
    b.sum.power += wrench.power;
    b.largest_power = std::max(b.largest_power, std::abs(wrench.power));
  }
  return b;
}

}  // namespace

TEST_CASE("the dimensionless plate runs through the reference states of the model sheet") {
  // Thin plate, default coefficients, started at vx = vy = w = 0.001, theta = pi/4; stated to 1e-6.
  const std::map<std::string, double> start = {
      {"vx(0)", 1e-3}, {"vy(0)", 1e-3}, {"w(0)", 1e-3}, {"theta(0)", kHalfTurn / 4}, {"beta", 0.0}};
  const ParametricModel model(find_model("falling_plate_nd"), start, {"inertia_ratio"});
  for (const PlanarReference& reference : kPlanarReferences) {
    INFO("I* = " << reference.I_star << ", t = " << reference.t);
    const Trajectory trajectory = integrate(model, std::array{reference.I_star}, std::array{reference.t});
    REQUIRE(trajectory.is_usable());
    for (std::size_t i = 0; i < 6; ++i) {
      CHECK_THAT(trajectory.states(0, static_cast<Eigen::Index>(i)), WithinAbs(reference.state[i], 1e-6));
    }
  }
}

TEST_CASE("the reference plate starts and stands where the model sheet puts it") {
  const auto model = find_model("falling_plate_nd");
  const std::vector<double> p = model->completed(all_default(*model));
  const std::vector<double> expected = {1.1, 1.0 / 14.0, 1.2,  kHalfTurn, 1.4, 1.0,
                                        0.2, 0.2,        1e-6, 0.0,       0.0, 1e3};
  CHECK(p == expected);
  const std::array<double, 6> start = {1e-3, 1e-3, 0.0, 0.4, 0.0, 0.0};
  for (std::size_t i = 0; i < 6; ++i) CHECK(model->info().states[i].default_initial == start[i]);
  CHECK(time_unit(model->info()) == "1");
}

TEST_CASE("freeing mu1 alone moves both dissipations") {
  const ParametricModel free(find_model("falling_plate_nd"), {}, {"mu1"});
  CHECK(free.parameters(std::array{0.27})[7] == 0.27);
  const ParametricModel both(find_model("falling_plate_nd"), {{"mu2", 0.2}}, {"mu1"});
  CHECK(both.parameters(std::array{0.27})[7] == 0.2);
}

TEST_CASE("falling broadside and edge-on are equilibria at the speeds of the model sheet") {
  for (const double beta : {0.0, 1.0 / 14.0, 0.5}) {
    const ParametricModel model(find_model("falling_plate_nd"), {{"speed_floor", 1e-12}}, {"beta"});
    ParametricModel::Workspace workspace = model.make_workspace();
    PlanarState rate;
    const double broadside = 1.1441140410797113;  // sqrt(pi/(A + B))
    model.rhs(0.0, PlanarState{0.0, -broadside, 0.0, 0.0, 0.0, 0.0}, std::array{beta}, rate, workspace);
    for (const std::size_t i : {kVx, kVy, kOmega}) CHECK_THAT(rate[i], WithinAbs(0.0, 1e-15));
    CHECK_THAT(rate[kY], WithinRel(-broadside, 1e-15));
    const double edge_on = 2.8024956081989645;  // sqrt(pi/(A - B))
    model.rhs(0.0, PlanarState{edge_on, 0.0, 0.0, -kHalfTurn / 2, 0.0, 0.0}, std::array{beta}, rate,
              workspace);
    for (const std::size_t i : {kVx, kVy, kOmega}) CHECK_THAT(rate[i], WithinAbs(0.0, 1e-15));
    CHECK_THAT(rate[kY], WithinRel(-edge_on, 1e-15));
  }
}

TEST_CASE("the plate in SI units is the dimensionless one, scaled") {
  // Length a, velocity U, I* = density b/(fluid_density a), beta = b/a.
  const double a = 7e-3, b = 5e-4, density = 2700.0, fluid = 998.2, g = 9.81;
  const double U = std::sqrt((density / fluid - 1.0) * g * b);
  const ParametricModel si(find_model("falling_plate"),
                           {{"semi_chord", a},
                            {"semi_thickness", b},
                            {"density", density},
                            {"vx(0)", 1e-3 * U},
                            {"vy(0)", 1e-3 * U}},
                           {});
  const ParametricModel nd(find_model("falling_plate_nd"),
                           {{"inertia_ratio", density * b / (fluid * a)}, {"beta", b / a}}, {});
  CHECK_THAT(si.scales({}).velocity, WithinRel(U, 1e-14));
  const std::array times = {1.0, 5.0, 10.0, 20.0};
  std::array<double, 4> seconds;
  for (std::size_t k = 0; k < 4; ++k) seconds[k] = times[k] * a / U;
  const Trajectory left = integrate(si, {}, seconds);
  const Trajectory right = integrate(nd, {}, times);
  REQUIRE(left.is_usable());
  REQUIRE(right.is_usable());
  const std::array units = {U, U, U / a, 1.0, a, a};
  for (Eigen::Index row = 0; row < 4; ++row) {
    for (Eigen::Index i = 0; i < 6; ++i) {
      // Two integrations of a fluttering plate, each good to about 1e-8 here (stated 1e-6 above).
      CHECK_THAT(left.states(row, i) / units[static_cast<std::size_t>(i)],
                 WithinAbs(right.states(row, i), 1e-6));
    }
  }
}

TEST_CASE("a plate as dense as the fluid stays where it is, and has derivatives") {
  const std::map<std::string, double> ellipse = {{"semi_chord", 7e-3}, {"semi_thickness", 5e-4}};
  const std::map<std::string, double> rectangle = {{"chord", 14e-3}, {"thickness", 1e-3}};
  for (const auto& [name, size] :
       {std::pair("falling_plate", ellipse), std::pair("falling_rectangle", rectangle)}) {
    INFO(name);
    const ParametricModel model(find_model(name), size, {"density", "C_T"});
    const Trajectory trajectory = integrate(model, std::array{998.2, 1.2}, std::array{1.0}, {}, true);
    REQUIRE(trajectory.is_usable());
    for (Eigen::Index i = 0; i < 6; ++i) CHECK(trajectory.states(0, i) == (i == kTheta ? 0.4 : 0.0));
    for (const Eigen::MatrixXd& s : trajectory.sensitivities) CHECK(s.allFinite());
    CHECK(trajectory.sensitivities[0](0, kY) < 0.0);  // a little denser, it sinks
  }
}

TEST_CASE("rates tend to those of the thin plate with the square of the thickness") {
  const auto model = find_model("falling_plate_nd");
  std::mt19937 random(3);
  const ParametricModel free(model, {}, {"beta"});
  ParametricModel::Workspace workspace = free.make_workspace();
  for (int k = 0; k < 20; ++k) {
    const PlanarState x = random_state(*model, all_default(*model), random);
    PlanarState thin, small, smaller;
    free.rhs(0.0, x, std::array{0.0}, thin, workspace);
    free.rhs(0.0, x, std::array{2e-3}, small, workspace);
    free.rhs(0.0, x, std::array{1e-3}, smaller, workspace);
    for (const std::size_t i : {kVx, kVy, kOmega}) {
      // Even in beta: the ratio of differences is 4 up to beta^2 ~ 4e-6 of the second derivative, which may
      // be small itself; and round-off of 1e-16 |f| / 1e-6.
      const double difference = smaller[i] - thin[i];
      CHECK_THAT(small[i] - thin[i], WithinAbs(4.0 * difference, 1e-4 * std::abs(difference) + 1e-10));
    }
  }
}

TEST_CASE(
    "inertia and lift do no work, drag and dissipation take it, and the breakdown is the energy's rate") {
  std::mt19937 random(5);
  for (const std::string& name : kPlates) {
    INFO(name);
    const auto model = find_model(name);
    for (int k = 0; k < 500; ++k) {
      const ParameterValues p = random_parameters(*model, random);
      const PlanarState x = random_state(*model, p, random);
      const Breakdown b = break_down(*model, x, p);
      const double round_off = 1e-13 * b.largest_power;
      // A lift is made of products as large as |force||velocity|, which may exceed every power.
      for (const char* idle : {"inertia", "translational lift", "rotational lift"}) {
        const Wrench& wrench = b.terms[term(*model, idle)];
        const double products = std::abs(wrench.force.x() * x[kVx]) + std::abs(wrench.force.y() * x[kVy]) +
                                std::abs(wrench.torque.z() * x[kOmega]);
        CHECK_THAT(wrench.power, WithinAbs(0.0, 1e-13 * products + round_off));
      }
      CHECK(b.terms[term(*model, "drag")].power <= 0.0);
      CHECK(b.terms[term(*model, "dissipation")].power <= 0.0);
      for (const Wrench& wrench : b.terms) {
        const Eigen::Vector3d velocity(x[kVx], x[kVy], 0.0);
        const double power = wrench.force.dot(velocity) + wrench.torque.z() * x[kOmega];
        CHECK_THAT(wrench.power, WithinAbs(power, 1e-12 * b.largest_power));
      }
    }
  }
}

TEST_CASE("the breakdown sums to the rates of momentum") {
  // Elliptic plates: (mass_x vx', mass_y vy', inertia w') with the inertias of the model sheet.
  std::mt19937 random(9);
  for (const std::string name : {"falling_plate_nd", "falling_plate"}) {
    const auto model = find_model(name);
    for (int k = 0; k < 100; ++k) {
      const ParameterValues p = random_parameters(*model, random);
      const PlanarState x = random_state(*model, p, random);
      PlanarState rate;
      model->rhs(0.0, x, p, rate);
      const Wrench sum = break_down(*model, x, p).sum;
      const std::vector<double>& v = p.value;
      double mass_x = v[0] + v[1] * v[1];
      double mass_y = v[0] + 1.0;
      double inertia = (v[0] * (1.0 + v[1] * v[1]) + std::pow(1.0 - v[1] * v[1], 2) / 2.0) / 4.0;
      if (name == "falling_plate") {
        const double a = v[0], b = v[1], solid = v[2], fluid = v[3];
        const double m = kHalfTurn * solid * a * b;
        mass_x = m + kHalfTurn * fluid * b * b;
        mass_y = m + kHalfTurn * fluid * a * a;
        inertia = m * (a * a + b * b) / 4.0 + kHalfTurn / 8.0 * fluid * std::pow(a * a - b * b, 2);
      }
      CHECK_THAT(sum.force.x(), WithinRel(mass_x * rate[kVx], 1e-12));
      CHECK_THAT(sum.force.y(), WithinRel(mass_y * rate[kVy], 1e-12));
      CHECK_THAT(sum.torque.z(), WithinRel(inertia * rate[kOmega], 1e-12));
    }
  }
}

TEST_CASE("a rectangle with its mass at one side obeys Kirchhoff's equations about its centre of mass") {
  // Momentum (Px, Py) and angular momentum L of body and fluid by the energy: P = dT/dv, L = dT/dw, here by
  // differences of a quadratic form, which are exact up to round-off. Their rates along f are the breakdown.
  const auto model = find_model("falling_rectangle");
  std::mt19937 random(11);
  for (int k = 0; k < 100; ++k) {
    const ParameterValues p = random_parameters(*model, random);
    const PlanarState x = random_state(*model, p, random);
    PlanarState rate;
    model->rhs(0.0, x, p, rate);
    const auto energy = [&](const PlanarState& at) { return *model->kinetic_energy(0.0, at, p); };
    // d/dt dT/dq_i = dT/dq_i at q', since dT/dq is linear.
    const auto momentum = [&](const PlanarState& at, std::size_t i) {
      PlanarState up = at, down = at;
      const double step = 1.0 + std::abs(at[i]);
      up[i] += step;
      down[i] -= step;
      return (energy(up) - energy(down)) / (2.0 * step);
    };
    const Wrench sum = break_down(*model, x, p).sum;
    const PlanarState q_rate = {rate[kVx], rate[kVy], rate[kOmega], 0.0, 0.0, 0.0};
    const double large = sum.force.norm();
    CHECK_THAT(momentum(q_rate, kVx), WithinAbs(sum.force.x(), 1e-10 * large));
    CHECK_THAT(momentum(q_rate, kVy), WithinAbs(sum.force.y(), 1e-10 * large));
    const double arms = large * p.value[0] + std::abs(sum.torque.z());
    CHECK_THAT(momentum(q_rate, kOmega), WithinAbs(sum.torque.z(), 1e-9 * arms));
  }
}

TEST_CASE("the masses of a rectangle are those of the model sheet") {
  const double a = 0.02, b = 0.001, solid = 2700.0, fluid = 998.2;
  const ParametricModel model(find_model("falling_rectangle"),
                              {{"chord", a}, {"thickness", b}, {"density", solid}}, {});
  ParameterValues p = all_given(model);
  const auto inertia = [&](std::size_t i) {
    PlanarState x = {};
    x[i] = 1.0;
    return 2.0 * *model.model().kinetic_energy(0.0, x, p);
  };
  const double m = solid * a * b;
  CHECK_THAT(inertia(kVx), WithinRel(m + 3.0 * kHalfTurn / 8.0 * fluid * b * b, 1e-14));
  CHECK_THAT(inertia(kVy), WithinRel(m + 3.0 * kHalfTurn / 8.0 * fluid * a * a, 1e-14));
  CHECK_THAT(inertia(kOmega), WithinRel(m * (a * a + b * b) / 12.0 +
                                            5.0 * kHalfTurn / 256.0 * fluid * std::pow(a * a - b * b, 2),
                                        1e-14));
}

TEST_CASE("the forces on a rectangle are those of (2.18)-(2.20) with its coefficients") {
  // Model sheet, section 3, rectangular plates: with v_p = vy - e w at the plate's centre,
  //   G = -C_T a vx v_p/v + C_R a^2 w/2, lift rho G (-v_p, vx),
  //   drag -1/2 rho a (C_0 cos^2 + C_pi sin^2) v (vx, v_p),  dissipation -C_tau rho a^4 |w| w/64,
  // forces at the plate's centre, x' = -e from the centre of mass, which torques are about.
  const double a = 0.02, rho = 998.2;
  const double C_T = 4.5, C_R = 1.8, C_0 = 0.2, C_pi = 0.5, C_tau = 1.9;
  struct Case {
    double e, vx, vy, w;
  };
  for (const Case& at : {Case{0.0, 0.11, -0.23, 4.0}, Case{0.006, -0.17, -0.08, -7.0}}) {
    INFO("offset " << at.e);
    const ParametricModel fixed(
        find_model("falling_rectangle"),
        {{"chord", a}, {"thickness", 0.001}, {"density", 2700.0}, {"offset", at.e}, {"speed_floor", 1e-12}},
        {});
    const ParameterValues p = all_given(fixed);
    const Breakdown b = break_down(fixed.model(), PlanarState{at.vx, at.vy, at.w, 0.3, 0.0, 0.0}, p);
    const double v_p = at.vy - at.e * at.w;
    const double v = std::hypot(at.vx, v_p);
    const double alpha = std::atan2(v_p, at.vx);
    const double drag =
        0.5 * rho * a * (C_0 * std::pow(std::cos(alpha), 2) + C_pi * std::pow(std::sin(alpha), 2)) * v;
    const double translation = -C_T * a * at.vx * v_p / v;
    const double rotation = C_R * a * a * at.w / 2.0;
    const auto check = [&](const char* name, double x, double y, double torque) {
      INFO(name);
      const Wrench& wrench = b.terms[term(fixed.model(), name)];
      CHECK_THAT(wrench.force.x(), WithinRel(x, 1e-13));
      CHECK_THAT(wrench.force.y(), WithinRel(y, 1e-13));
      CHECK_THAT(wrench.torque.z(), WithinAbs(torque, 1e-13 * std::abs(torque)));
    };
    check("drag", -drag * at.vx, -drag * v_p, at.e * drag * v_p);
    check("translational lift", -rho * translation * v_p, rho * translation * at.vx,
          -at.e * rho * translation * at.vx);
    check("rotational lift", -rho * rotation * v_p, rho * rotation * at.vx, -at.e * rho * rotation * at.vx);
    check("dissipation", 0.0, 0.0, -C_tau * rho * std::pow(a, 4) * std::abs(at.w) * at.w / 64.0);
  }
}

TEST_CASE("a centre of mass beyond the ends of a rectangle is refused") {
  const std::map<std::string, double> plate = {{"chord", 0.02}, {"thickness", 0.002}, {"density", 2000.0}};
  const ParametricModel model(find_model("falling_rectangle"), plate, {"offset"});
  CHECK_NOTHROW(model.check(std::array{-0.01}));
  CHECK_THROWS_WITH(model.check(std::array{5.0}), Contains("offset is 5 m") && Contains("at most 0.01 m"));
}

TEST_CASE("a rectangle heavy at one end falls with this end down") {
  const ParametricModel model(find_model("falling_rectangle"),
                              {{"chord", 0.02}, {"thickness", 0.002}, {"density", 2000.0}, {"offset", 0.006}},
                              {});
  const Trajectory trajectory = integrate(model, {}, std::array{3.0});
  REQUIRE(trajectory.is_usable());
  // The heavy end lies at +x': straight down is theta = -pi/2, an attitude without torque.
  CHECK_THAT(trajectory.states(0, kTheta), WithinAbs(-kHalfTurn / 2, 0.05));
  CHECK_THAT(trajectory.states(0, kOmega), WithinAbs(0.0, 0.05));
}

TEST_CASE("the rates of the plates split exactly by their coefficients") {
  std::mt19937 random(13);
  for (const std::string& name : kPlates) {
    INFO(name);
    const auto model = find_model(name);
    for (int k = 0; k < 20; ++k) {
      const ParameterValues p = random_parameters(*model, random);
      const PlanarState x = random_state(*model, p, random);
      const AffineSplit split = affine_split(*model, 0.0, x, p);
      REQUIRE(split.names == model->info().affine_in);
      const ParameterValues other = random_parameters(*model, random);
      ParameterValues mixed = p;
      Eigen::VectorXd coefficients(split.slopes.cols());
      for (std::size_t j = 0; j < split.names.size(); ++j) {
        for (std::size_t i = 0; i < mixed.value.size(); ++i) {
          if (model->info().parameters[i].name == split.names[j]) {
            coefficients[static_cast<Eigen::Index>(j)] = mixed.value[i] = other.value[i];
          }
        }
      }
      PlanarState rate;
      model->rhs(0.0, x, mixed, rate);
      const Eigen::VectorXd summed = split.constant + split.slopes * coefficients;
      const double large =
          split.constant.cwiseAbs().maxCoeff() + (split.slopes.cwiseAbs() * coefficients).maxCoeff();
      for (Eigen::Index i = 0; i < 6; ++i) {
        CHECK_THAT(rate[static_cast<std::size_t>(i)], WithinAbs(summed[i], 1e-13 * large));
      }
    }
  }
}
