#include <catch2/catch.hpp>

#include "bodies_in_flow.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

using Values = std::map<std::string, double>;

/// A miniature blimp with the coefficients its makers fitted (Zhu, Cheng, Zhang 2024, published parameters).
Values blimp() {
  return {{"mass", 0.10482},
          {"I_x", 0.03},
          {"I_y", 0.015},
          {"I_z", 0.01},
          {"r_cx", -0.0432},
          {"r_cy", -0.0003},
          {"r_cz", 0.0079},
          {"offset_mass", 0.05407},
          {"offset_x", 0.0747},
          {"offset_y", 0.0006},
          {"offset_z", 0.238},
          {"displaced_mass", 0.15204},
          {"fluid_density", 1.2187},
          {"g", 9.8},
          {"area", 0.25},
          {"thrust_arm", 0.15},
          {"thrust_left", 0.02},
          {"thrust_right", 0.03},
          {"Cd0", 0.2425},
          {"Cda", 4.4195},
          {"Cdb", 7.5080},
          {"Cs0", 0.0083},
          {"Csa", -0.0744},
          {"Csb", -2.1140},
          {"Cl0", 0.1594},
          {"Cla", 2.9375},
          {"Clb", 4.5537},
          {"Cmx0", 0.0131},
          {"Cmxa", -0.0301},
          {"Cmxb", -0.5256},
          {"Cmy0", 0.0568},
          {"Cmya", 0.0933},
          {"Cmyb", 5.2357},
          {"Cmz0", 0.0006},
          {"Cmza", -0.0012},
          {"Cmzb", -0.0936},
          {"K1", -0.0503},
          {"K2", -0.0264},
          {"K3", -0.0137}};
}

using Rates = Eigen::Matrix<double, 6, 1>;

/// The makers' equations of motion, term by term: forces at the origin in body axes, gravity along `down`
/// (body components), flow angles by trigonometry.
Rates published_rates(const Values& v, const Eigen::Vector3d& u, const Eigen::Vector3d& w,
                      const Eigen::Vector3d& down) {
  const auto value = [&v](const char* name) { return v.at(name); };
  const Eigen::Vector3d r(value("r_cx"), value("r_cy"), value("r_cz"));
  const Eigen::Vector3d rb(value("offset_x"), value("offset_y"), value("offset_z"));
  const double m = value("mass"), mb = value("offset_mass"), g = value("g");
  const double alpha = std::atan2(u.z(), u.x());
  const double beta = std::asin(u.y() / u.norm());
  const double q = 0.5 * value("fluid_density") * u.squaredNorm() * value("area");
  const double D = q * (value("Cd0") + value("Cda") * alpha * alpha + value("Cdb") * beta * beta);
  const double S = q * (value("Cs0") + value("Csa") * alpha * alpha + value("Csb") * beta);
  const double L = q * (value("Cl0") + value("Cla") * alpha + value("Clb") * beta * beta);
  const Eigen::Vector3d moments =
      q * Eigen::Vector3d(value("Cmx0") + value("Cmxa") * alpha + value("Cmxb") * beta,
                          value("Cmy0") + value("Cmya") * alpha + value("Cmyb") * std::pow(beta, 4),
                          value("Cmz0") + value("Cmza") * alpha + value("Cmzb") * beta);
  const Eigen::Vector3d damping(value("K1") * w.x(), value("K2") * w.y(), value("K3") * w.z());
  Eigen::Matrix3d from_flow;
  from_flow << std::cos(alpha) * std::cos(beta), -std::cos(alpha) * std::sin(beta), -std::sin(alpha),
      std::sin(beta), std::cos(beta), 0.0, std::sin(alpha) * std::cos(beta),
      -std::sin(alpha) * std::sin(beta), std::cos(alpha);
  const Eigen::Vector3d l = m * r + mb * rb;
  const Eigen::Matrix3d I =
      Eigen::Vector3d(value("I_x"), value("I_y"), value("I_z")).asDiagonal().toDenseMatrix() -
      mb * cross_matrix(rb) * cross_matrix(rb);
  Eigen::Vector3d force = (m + mb) * u.cross(w) + w.cross(l).cross(w) +
                          (m + mb - value("displaced_mass")) * g * down +
                          from_flow * Eigen::Vector3d(-D, S, -L);
  Eigen::Vector3d torque =
      (I * w).cross(w) + l.cross(u.cross(w)) + l.cross(g * down) + from_flow * (moments + damping);
  const double left = value("thrust_left"), right = value("thrust_right");
  force.x() += left + right;
  torque.y() += (left + right) * rb.z();
  torque.z() += (left - right) * value("thrust_arm");
  Eigen::Matrix<double, 6, 6> H;
  H << (m + mb) * Eigen::Matrix3d::Identity(), -cross_matrix(l), cross_matrix(l), I;
  Rates right_hand_side;
  right_hand_side << force, torque;
  return H.partialPivLu().solve(right_hand_side);
}

}  // namespace

TEST_CASE("with the blimp's published coefficients the body follows its makers' equations") {
  const auto model = find_model("coefficient_body");
  Values values = blimp();
  values["speed_floor"] = 1e-12;
  const ParameterValues p = parameter_values(*model, values);
  std::mt19937 random(12);
  for (int k = 0; k < 200; ++k) {
    BodyState state;
    state.q = random_attitude(random);
    state.u = Eigen::Vector3d(0.5, 0.0, 0.1) + random_vector(random, 0.1);
    state.w = random_vector(random, 0.3);
    Eigen::VectorXd f(13);
    model->rhs(0.0, state.vector(), p, {f.data(), 13});
    const Rates expected = published_rates(values, state.u, state.w, -state.R().row(2).transpose());
    CHECK((f.tail<6>() - expected).norm() < 1e-10 * expected.norm());
  }
}

TEST_CASE("the coefficient body has finite rates and derivatives at rest and in flow from behind") {
  const auto model = find_model("coefficient_body");
  for (const double floor : {1e-12, 1e-6, 0.02}) {
    Values values = blimp();
    values["speed_floor"] = floor;
    const ParameterValues p = parameter_values(*model, values);
    for (const Eigen::Vector3d& u : {Eigen::Vector3d(-floor, 0.0, 0.0), Eigen::Vector3d(0.0, 0.0, 0.0),
                                     Eigen::Vector3d(-1.0, 0.0, 0.0), Eigen::Vector3d(0.0, 1.0, 0.0)}) {
      INFO("u = " << u.transpose() << ", floor " << floor);
      BodyState state;
      state.u = u;
      state.w = {0.1, -0.2, 0.15};
      std::vector<double> f(13);
      Eigen::MatrixXd df_dx(13, 13);
      Eigen::MatrixXd df_dp(13, static_cast<Eigen::Index>(p.value.size()));
      model->rhs_with_derivatives(0.0, state.vector(), p, f, df_dx, df_dp);
      CHECK(Eigen::Map<Eigen::VectorXd>(f.data(), 13).allFinite());
      CHECK(df_dx.allFinite());
      CHECK(df_dp.allFinite());
    }
  }
}

TEST_CASE("the angles of flow are exact to the second order of the speed floor") {
  // With lift q alpha and side force q beta alone, q known, the sizes of these forces are the angles. From
  // the front they err by less than (floor/|u|)^2/2, in even powers: twice the floor, four times the error,
  // but for (floor/|u|)^2 ~ 2e-3 of that.
  const auto model = find_model("coefficient_body");
  Values values = blimp();
  for (const char* name : {"Cd0", "Cda", "Cdb", "Cs0", "Csa", "Cl0", "Clb"}) values[name] = 0.0;
  values["Cla"] = values["Csb"] = 1.0;
  const Eigen::Vector3d u(0.5, 0.1, 0.2);
  const double q = 0.5 * values["fluid_density"] * values["area"] * u.squaredNorm();
  BodyState state;
  state.u = u;
  const auto errors = [&](double floor) {
    values["speed_floor"] = floor;
    const ParameterValues p = parameter_values(*model, values);
    std::vector<Wrench> terms(model->info().force_terms.size());
    model->forces(0.0, state.vector(), p, terms);
    return Eigen::Vector2d(terms[3].force.norm() / q - std::atan2(u.z(), u.x()),
                           terms[2].force.norm() / q - std::asin(u.y() / u.norm()));
  };
  const double floor = 0.01;
  const Eigen::Vector2d at_floor = errors(floor);
  const Eigen::Vector2d at_twice = errors(2.0 * floor);
  for (int i = 0; i < 2; ++i) {
    CHECK(std::abs(at_floor[i]) < 0.5 * floor * floor / u.squaredNorm());
    CHECK_THAT(at_twice[i] / at_floor[i], WithinRel(4.0, 0.01));
  }
  CHECK(errors(1e-9).cwiseAbs().maxCoeff() < 1e-15);
}

TEST_CASE("the blimp glides forward and sinks slowly in trim") {
  // World x north, z up: level flight is a half turn about x. Both propellers at 20 mN.
  Values values = blimp();
  values["thrust_right"] = 0.02;
  BodyState start;
  start.q = {0.0, 1.0, 0.0, 0.0};
  start.u = {0.4, 0.0, 0.1};
  const Eigen::MatrixXd states = motion(find_model("coefficient_body"), values, start, {5.0, 10.0}, 1e-9);
  const BodyState end(states.row(1));
  CHECK(end.u.x() > 0.2);
  CHECK(end.u.x() < 1.0);
  CHECK(end.position.z() < 0.0);
  CHECK(end.R()(2, 2) < -0.8);  // body z stays down
}

TEST_CASE("the terms of the coefficient body sum to the rate of momentum, their powers to that of energy") {
  const auto model = find_model("coefficient_body");
  Values values = blimp();
  for (const char* name : {"M_x", "M_y", "M_z"}) values[name] = 0.05;
  for (const char* name : {"J_x", "J_y", "J_z"}) values[name] = 0.004;
  const ParameterValues p = parameter_values(*model, values);
  std::mt19937 random(13);
  for (int k = 0; k < 50; ++k) {
    BodyState state;
    state.q = random_attitude(random);
    state.u = Eigen::Vector3d(0.5, 0.0, 0.1) + random_vector(random, 0.1);
    state.w = random_vector(random, 0.3);
    const std::vector<double> x = state.vector();
    std::vector<double> f(13);
    model->rhs(0.0, x, p, f);
    std::vector<Wrench> terms(model->info().force_terms.size());
    model->forces(0.0, x, p, terms);
    double power = 0.0;
    double size = 0.0;
    for (const Wrench& term : terms) {
      power += term.power;
      size += std::abs(term.power);
    }
    const double h = 1e-5;
    const auto energy = [&](double way) {
      std::vector<double> moved = x;
      for (std::size_t i = 0; i < 13; ++i) moved[i] += way * f[i];
      return *model->kinetic_energy(0.0, moved, p);
    };
    // The energy is quadratic in u and w: central differences are exact but for round-off 1e-16/h of it.
    CHECK_THAT((energy(h) - energy(-h)) / (2.0 * h), WithinAbs(power, 1e-8 * size + 1e-11));
  }
}

TEST_CASE("the coefficient body is affine in its coefficients and thrusts, all together") {
  const auto model = find_model("coefficient_body");
  const ParameterValues p = parameter_values(*model, blimp());
  BodyState state;
  state.q = Eigen::Quaterniond(0.1, 0.9, -0.2, 0.3).normalized();
  state.u = {0.5, -0.05, 0.12};
  state.w = {0.1, -0.2, 0.15};
  const AffineSplit split = affine_split(*model, 0.0, state.vector(), p);
  REQUIRE(split.names.size() == 23);
  Eigen::VectorXd sum = split.constant;
  for (std::size_t j = 0; j < split.names.size(); ++j) {
    sum += parameter(*model, p, split.names[j]) * split.slopes.col(static_cast<Eigen::Index>(j));
  }
  Eigen::VectorXd f(13);
  model->rhs(0.0, state.vector(), p, {f.data(), 13});
  CHECK((sum - f).norm() < 1e-12 * f.norm());
}
