// What a gradient of the fluid does to bodies in it.
#include <numbers>

#include <catch2/catch.hpp>

#include "../bodies_in_flow.h"
#include "samara/models/bodies/kirchhoff_parameters.h"
#include "samara/models/laws/ambient_flow.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/fluid_seen.h"
#include "samara/models/stochastic/realisations.h"
#include "samara/models/stochastic/turbulent_flow.h"

using namespace samara::models;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// w_air = w_0 + W x
struct SteadyFlow {
  Eigen::Vector3d w_0;
  Eigen::Matrix3d W;
  Eigen::Vector3d operator()(const Eigen::Vector3d& x) const { return w_0 + W * x; }
};

Eigen::Matrix3d random_matrix(std::mt19937& random, double size) {
  Eigen::Matrix3d m;
  for (int j = 0; j < 3; ++j) m.col(j) = random_vector(random, size);
  return m;
}

/// The gust that a body at a place with a velocity meets in the flow, by its parameters in space.
std::map<std::string, double> gust_in(const SteadyFlow& flow, const Eigen::Vector3d& place,
                                      const Eigen::Vector3d& velocity) {
  std::map<std::string, double> values;
  const Eigen::Vector3d air = flow(place), rate = flow.W * velocity;
  for (int i = 0; i < 3; ++i) {
    const std::string axis(1, "xyz"[i]);
    values["gust_" + axis] = air[i];
    values["gust_rate_" + axis] = rate[i];
    for (int j = 0; j < 3; ++j) values["gust_gradient_" + axis + "xyz"[j]] = flow.W(i, j);
  }
  return values;
}

Eigen::VectorXd rates_of(const Model& model, const std::vector<double>& x,
                         const std::map<std::string, double>& values) {
  Eigen::VectorXd f(static_cast<Eigen::Index>(x.size()));
  model.rhs(0.0, x, parameter_values(model, values), {f.data(), x.size()});
  return f;
}

/// |dh/dt| along the rates f at x, over the sum of the sizes of its parts.
template <class Integral>
double drift(const Integral& h, const std::vector<double>& x, const Eigen::VectorXd& f) {
  const auto change = [&](const std::vector<bool>& moves) {
    std::vector<double> above = x, below = x;
    constexpr double kStep = 1e-5;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double way = moves[i] ? kStep * f[static_cast<Eigen::Index>(i)] : 0.0;
      above[i] += way;
      below[i] -= way;
    }
    return (h(above) - h(below)) / (2.0 * kStep);
  };
  double size = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    std::vector<bool> one(x.size(), false);
    one[i] = true;
    size += std::abs(change(one));
  }
  return std::abs(change(std::vector<bool>(x.size(), true))) / size;
}

}  // namespace

TEST_CASE("a sphere in a gradient is pushed and lifted as Auton, Hunt and Prud'homme have it") {
  const auto model = find_model("sphere_flight_in_gusts");
  const double m = 0.3, m_f = 0.5, g = 9.81;
  const std::map<std::string, double> body = {{"mass", m}, {"displaced_mass", m_f}, {"added_mass", 0.5 * m_f},
                                              {"g", g},    {"C_D", 1e-30},          {"C_M", 0.0}};
  std::mt19937 random(3);
  for (int k = 0; k < 20; ++k) {
    const SteadyFlow flow = {random_vector(random, 1.0), random_matrix(random, 2.0)};
    const Eigen::Vector3d x = random_vector(random, 1.0), air = flow(x);
    // Held, the last ones: 3/2 m_f D w_air/Dt, and the lift.
    const Eigen::Vector3d v = k < 15 ? random_vector(random, 1.0) : Eigen::Vector3d::Zero();
    const Eigen::Vector3d curl(flow.W(2, 1) - flow.W(1, 2), flow.W(0, 2) - flow.W(2, 0),
                               flow.W(1, 0) - flow.W(0, 1));
    const Eigen::Vector3d force = 1.5 * m_f * (flow.W * air) + 0.5 * m_f * (air - v).cross(curl) -
                                  (m - m_f) * g * Eigen::Vector3d::UnitZ();
    const std::vector<double> state = {x.x(), x.y(), x.z(), v.x(), v.y(), v.z(), 0.0, 0.0, 0.0};
    const Eigen::VectorXd f = rates_of(*model, state, joined(body, gust_in(flow, x, v)));
    CHECK((f.segment<3>(3) - force / (m + 0.5 * m_f)).norm() < 1e-12 * force.norm() / m);
  }
}

TEST_CASE(
    "a gradient of any kind acts on bodies in space by its transposed times the momentum of the fluid") {
  std::mt19937 random(6);
  const Eigen::Vector3d M(0.05, 0.15, 0.2);
  const std::map<std::string, double> masses = {{"mass", 0.3}, {"displaced_mass", 0.2}};
  const std::map<std::string, double> added = {{"M_x", M.x()}, {"M_y", M.y()}, {"M_z", M.z()}};
  const std::map<std::string, double> coupled = {
      {"K_11", M.x()}, {"K_22", M.y()}, {"K_33", M.z()}, {"K_15", 0.02}, {"K_44", 0.1},
      {"K_55", 0.1},   {"K_66", 0.1},   {"I_xx", 0.1},   {"I_yy", 0.1},  {"I_zz", 0.1}};
  const std::map<std::string, double> inertia = {{"I_x", 0.1}, {"I_y", 0.1}, {"I_z", 0.1}, {"area", 0.3}};
  const std::map<std::string, double> axes = {{"a", 0.35}, {"b", 0.2}, {"c", 0.1}, {"density", 10.0}};
  for (const auto& [name, own] : {std::pair{"immersed_body_in_gusts", joined(axes, added)},
                                  std::pair{"coefficient_body_in_gusts", joined(inertia, added)},
                                  std::pair{"kirchhoff_body_in_gusts", coupled}}) {
    INFO(name);
    const auto model = find_model(name);
    const double coupling = own.contains("K_15") ? own.at("K_15") : 0.0;
    for (int k = 0; k < 10; ++k) {
      const SteadyFlow flow = {random_vector(random, 1.0), random_matrix(random, 1.0)};
      BodyState state;
      state.q = random_attitude(random);
      state.u = random_vector(random, 1.0);
      state.w = random_vector(random, 1.0);
      const Eigen::Vector3d v = state.R() * state.u;
      std::map<std::string, double> gust = gust_in(flow, state.position, v);
      const auto ambient_force = [&] {
        std::vector<Wrench> terms(model->info().force_terms.size());
        REQUIRE(model->info().force_terms.back().name == "ambient acceleration");
        model->forces(0.0, state.vector(), parameter_values(*model, joined(joined(masses, own), gust)),
                      terms);
        return Eigen::Vector3d(terms.back().force);
      };
      const Eigen::Vector3d with = ambient_force();
      for (auto& [parameter, value] : gust) {
        if (parameter.starts_with("gust_gradient")) value = 0.0;
      }
      const Eigen::Vector3d slip = v - flow(state.position);
      const Eigen::Vector3d u_r = state.R().transpose() * slip;
      const Eigen::Vector3d momentum =
          M.cwiseProduct(u_r) + coupling * state.w.y() * Eigen::Vector3d::UnitX();
      const Eigen::Vector3d expected =
          -state.R().transpose() * (0.2 * flow.W * slip + flow.W.transpose() * (state.R() * momentum));
      CHECK((with - ambient_force() - expected).norm() < 1e-13 * (1.0 + expected.norm()));
    }
  }
}

TEST_CASE("in a steady potential flow bodies in space that nothing slows keep the integral of Jacobi") {
  // Lagrange's function is T_body + 1/2 (u_r, w) K (u_r, w) + 1/2 m_f |w_air|^2: the pressure gradient is conservative.
  std::mt19937 random(8);
  KirchhoffBodyData any;
  any.mass = 0.3;
  any.displaced_mass = 0.2;
  any.inertia << 0.02, 0.002, 0.0, 0.002, 0.03, -0.001, 0.0, -0.001, 0.025;
  any.centre_of_mass = {0.05, -0.03, 0.04};
  Matrix6 root;
  for (int j = 0; j < 6; ++j) root.col(j) << random_vector(random, 0.3), random_vector(random, 0.05);
  any.added_mass = root * root.transpose();
  const Eigen::Matrix3d r = cross_matrix(any.centre_of_mass);
  Matrix6 of_body;
  of_body << any.mass * Eigen::Matrix3d::Identity(), -any.mass * r, any.mass * r,
      any.inertia - any.mass * r * r;
  struct Case {
    const char* model;
    std::map<std::string, double> values;
    Matrix6 body, fluid;
    double displaced;
  };
  std::vector<Case> cases = {{"kirchhoff_body_in_gusts", joined(kirchhoff_parameters(any), {{"g", 0.0}}),
                              of_body, any.added_mass, any.displaced_mass}};
  const std::map<std::string, double> plain = {
      {"a", 0.35}, {"b", 0.2},     {"c", 0.1},    {"density", 2.0}, {"fluid_density", 3.0},
      {"g", 0.0},  {"C_D90", 0.0}, {"C_D0", 0.0}, {"C_T", 0.0},     {"C_R", 0.0},
      {"C_w", 0.0}};
  const auto immersed = find_model("immersed_body_in_gusts");
  const ParameterValues p = parameter_values(*immersed, plain);
  const auto value = [&](const std::string& name) { return parameter(*immersed, p, name); };
  const auto diagonal = [&](const char* linear, const char* angular) {
    Vector6 entries;
    for (int i = 0; i < 3; ++i) {
      entries[i] = *linear == '\0' ? value("mass") : value(std::string(linear) + "xyz"[i]);
      entries[3 + i] = value(std::string(angular) + "xyz"[i]);
    }
    return Matrix6(entries.asDiagonal());
  };
  cases.push_back(
      {"immersed_body_in_gusts", plain, diagonal("", "I_"), diagonal("M_", "J_"), value("displaced_mass")});
  for (const Case& of : cases) {
    INFO(of.model);
    const auto model = find_model(of.model);
    for (int k = 0; k < 20; ++k) {
      const Eigen::Matrix3d any_gradient = random_matrix(random, 1.0);
      const SteadyFlow flow = {random_vector(random, 1.0), any_gradient + any_gradient.transpose()};
      BodyState state;
      state.position = random_vector(random, 1.0);
      state.q = random_attitude(random);
      state.u = random_vector(random, 1.0);
      state.w = random_vector(random, 1.0);
      const auto integral = [&](const std::vector<double>& x) {
        const BodyState at(Eigen::VectorXd::Map(x.data(), 13));
        const Eigen::Vector3d air = flow(at.position);
        Vector6 motion, carried = Vector6::Zero();
        motion << at.u, at.w;
        carried.head<3>() = at.R().transpose() * air;
        return 0.5 * (motion.dot((of.body + of.fluid) * motion) - carried.dot(of.fluid * carried) -
                      of.displaced * air.squaredNorm());
      };
      const std::vector<double> x = state.vector();
      const Eigen::VectorXd f =
          rates_of(*model, x, joined(of.values, gust_in(flow, state.position, state.R() * state.u)));
      // Central differences: the step squared, and round-off over the step.
      CHECK(drift(integral, x, f) < 1e-8);
    }
  }
}

TEST_CASE("in a steady potential flow a plate that nothing slows keeps the integral of Jacobi") {
  const auto model = find_model("falling_plate_in_gusts");
  const std::map<std::string, double> plate = {{"semi_chord", 0.4}, {"semi_thickness", 0.1},
                                               {"density", 2.0},    {"fluid_density", 3.0},
                                               {"g", 0.0},          {"C_T", 0.0},
                                               {"C_R", 0.0},        {"A", 0.0},
                                               {"B", 0.0},          {"mu1", 0.0},
                                               {"mu2", 0.0}};
  constexpr double kPi = std::numbers::pi, a = 0.4, b = 0.1;
  const double mass = kPi * 2.0 * a * b, displaced = kPi * 3.0 * a * b;
  const Eigen::Vector2d added(kPi * 3.0 * b * b, kPi * 3.0 * a * a);
  const double inertia = 0.25 * mass * (a * a + b * b) + kPi / 8.0 * 3.0 * std::pow(a * a - b * b, 2);
  std::mt19937 random(4);
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d drawn = random_vector(random, 1.0), start = random_vector(random, 1.0);
    const Eigen::Vector2d w_0 = random_vector(random, 1.0).head<2>();
    Eigen::Matrix2d W;
    W << drawn[0], drawn[1], drawn[1], drawn[2];
    const auto turn = [](double theta) { return Eigen::Rotation2Dd(theta).toRotationMatrix(); };
    const auto air_at = [&](double X, double Y) -> Eigen::Vector2d {
      return w_0 + W * Eigen::Vector2d(X, Y);
    };
    const auto integral = [&](const std::vector<double>& x) {
      const Eigen::Vector2d v(x[0], x[1]), air = air_at(x[4], x[5]), along = turn(x[3]).transpose() * air;
      return 0.5 * (mass * v.squaredNorm() + v.dot(added.asDiagonal() * v) + inertia * x[2] * x[2] -
                    along.dot(added.asDiagonal() * along) - displaced * air.squaredNorm());
    };
    const std::vector<double> x = {drawn[1], start[0], start[1], start[2], drawn[2], drawn[0]};
    const Eigen::Vector2d air = air_at(x[4], x[5]), rate = W * (turn(x[3]) * Eigen::Vector2d(x[0], x[1]));
    const Eigen::VectorXd f = rates_of(*model, x,
                                       joined(plate, {{"gust_x", air[0]},
                                                      {"gust_y", air[1]},
                                                      {"gust_rate_x", rate[0]},
                                                      {"gust_rate_y", rate[1]},
                                                      {"gust_gradient_xx", W(0, 0)},
                                                      {"gust_gradient_xy", W(0, 1)},
                                                      {"gust_gradient_yx", W(1, 0)},
                                                      {"gust_gradient_yy", W(1, 1)}}));
    CHECK(drift(integral, x, f) < 1e-8);
  }
}

TEST_CASE(
    "in a plane the ramps of a mean flow with a gradient lead to the motion in that flow, to second order") {
  // Of the flow's gradient the plate sees what is of x and z. Light, so that the gradient counts.
  Eigen::Matrix3d A;
  A << 0.8, 0.3, 1.5, -0.4, 0.2, 0.6, 0.5, -0.7, -1.0;
  const Eigen::Vector3d w_0(0.4, 0.0, 0.2);
  const std::map<std::string, double> plate = {{"semi_chord", 0.02},
                                               {"semi_thickness", 0.002},
                                               {"density", 300.0},
                                               {"theta(0)", 0.4},
                                               {"speed_floor", 1e-2}};
  const auto model = find_model("falling_plate_in_gusts");
  const auto rates = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    const Eigen::Vector3d air = w_0 + A * Eigen::Vector3d(x[4], 0.0, x[5]);
    const Eigen::Vector2d v = Eigen::Rotation2Dd(x[3]) * Eigen::Vector2d(x[0], x[1]);
    const Eigen::Vector3d rate = A * Eigen::Vector3d(v[0], 0.0, v[1]);
    return rates_of(*model, {x.begin(), x.end()},
                    joined(plate, {{"gust_x", air[0]},
                                   {"gust_y", air[2]},
                                   {"gust_rate_x", rate[0]},
                                   {"gust_rate_y", rate[2]},
                                   {"gust_gradient_xx", A(0, 0)},
                                   {"gust_gradient_xy", A(0, 2)},
                                   {"gust_gradient_yx", A(2, 0)},
                                   {"gust_gradient_yy", A(2, 2)}}));
  };
  Eigen::VectorXd exact = Eigen::VectorXd::Zero(6);
  exact[3] = 0.4;
  constexpr double h = 1e-4;
  for (int k = 0; k < 2000; ++k) {
    const Eigen::VectorXd k1 = rates(exact), k2 = rates(exact + 0.5 * h * k1),
                          k3 = rates(exact + 0.5 * h * k2), k4 = rates(exact + h * k3);
    exact += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  const auto flow = turbulent_flow(
      [&](double, const Eigen::Vector3d& x) { return AmbientSample{.velocity = w_0 + A * x, .gradient = A}; },
      [](double, const Eigen::Vector3d&) { return Turbulence{.epsilon = 1.0}; }, 1.0);
  const std::vector<double> times = {0.2};
  double errors[2];
  for (const int halvings : {0, 1}) {
    const Ensemble cloud = realise(ParametricModel(model, plate, {}), {}, *fluid_seen_in(flow, 1), times,
                                   {.realisations = 1, .step = 1e-3 / (1 << halvings), .keep = 1});
    errors[halvings] = (cloud.kept[0].row(0).tail<2>() - exact.tail<2>().transpose()).norm();
  }
  CHECK(errors[0] < 1e-4);
  CHECK(errors[0] / errors[1] > 3.0);
}
