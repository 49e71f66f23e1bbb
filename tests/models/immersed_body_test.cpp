#include <array>

#include <catch2/catch.hpp>

#include "immersed_card.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

Eigen::VectorXd rhs(const Model& model, const BodyState& state, const ParameterValues& p) {
  Eigen::VectorXd f(13);
  model.rhs(0.0, state.vector(), p, {f.data(), 13});
  return f;
}

}  // namespace

TEST_CASE("the masses of the immersed card are those of the reference") {
  const auto model = find_model("immersed_body");
  const ParameterValues p = parameter_values(*model, card());
  const auto value = [&](const char* name) { return parameter(*model, p, name); };
  CHECK_THAT(value("mass"), WithinRel(3.518584e-4, 2e-7));
  CHECK_THAT(value("mass") + value("M_x"), WithinRel(3.518590e-4, 2e-7));
  CHECK_THAT(value("mass") + value("M_y"), WithinRel(3.518599e-4, 2e-7));
  CHECK_THAT(value("mass") + value("M_z"), WithinRel(4.077743e-4, 2e-7));
  CHECK_THAT(value("I_x") + value("J_x"), WithinRel(3.078347e-8, 2e-7));
  CHECK_THAT(value("I_y") + value("J_y"), WithinRel(9.673374e-8, 2e-7));
  CHECK_THAT(value("I_z") + value("J_z"), WithinRel(1.143541e-7, 2e-7));
}

TEST_CASE("the immersed card reaches the reference states at 0.3 s") {
  BodyState start;
  start.q = {std::cos(0.15), std::sin(0.15) * std::cos(0.6), std::sin(0.15) * std::sin(0.6), 0.0};
  start.u = {0.05, 0.05, -0.1};
  start.w = {1.0, 2.0, 3.0};
  struct Reference {
    double velocity_chord;
    Eigen::Vector3d x, u, w;
  };
  // The second from a program of its own: Runge-Kutta steps of 0.1 ms, which 0.2 ms change in the ninth digit.
  const std::array references = {Reference{1.0,
                                           {0.010662110421, -0.024859850787, -0.326721668383},
                                           {1.595843879144, -0.010333922442, -1.092395691472},
                                           {40.8267535055, -2.1644425981, 14.3270031910}},
                                 Reference{0.0,
                                           {0.0072677383, -0.0244060341, -0.3213395838},
                                           {1.5496843536, -0.4566933930, -1.0305594699},
                                           {41.382021679, 4.901106987, 5.128276123}}};
  for (const Reference& reference : references) {
    CAPTURE(reference.velocity_chord);
    const Values values = with(card(), {{"velocity_chord", reference.velocity_chord}});
    const BodyState end(motion(find_model("immersed_body"), values, start, {0.3}).row(0));
    const double scatter = 1e-7;
    CHECK((end.position - reference.x).norm() < scatter * reference.x.norm());
    CHECK((end.u - reference.u).norm() < scatter * reference.u.norm());
    CHECK((end.w - reference.w).norm() < scatter * reference.w.norm());
    CHECK_THAT(end.q.norm(), WithinAbs(1.0, 1e-9));
  }
}

TEST_CASE("a card that falls broadside reaches the terminal speed") {
  const double vt = 1.201606659242496;
  BodyState start;
  const Eigen::MatrixXd states =
      motion(find_model("immersed_body"), with(card(), {{"C_D90", 1.81}}), start, {5.0});
  CHECK_THAT(states(0, 9), WithinRel(-vt, 1e-9));
  CHECK(states.row(0).segment<2>(7).norm() == 0.0);
  CHECK(states.row(0).segment<3>(10).norm() == 0.0);
}

TEST_CASE("a release that is planar by symmetry stays in its plane") {
  const auto model = find_model("immersed_body");
  for (const double cop : {0.0, 1.0}) {
    BodyState about_y;
    about_y.q = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY());
    about_y.u = {0.1, 0.0, -0.2};
    const Eigen::MatrixXd states =
        motion(model, with(card(), {{"centre_of_pressure", cop}}), about_y, {0.2, 0.5, 1.0}, 1e-9);
    // Every product that could leave the plane has a factor that is zero exactly.
    for (const int i : {1, 4, 6, 8, 10, 12}) CHECK(states.col(i).cwiseAbs().maxCoeff() == 0.0);
    BodyState about_x;
    about_x.q = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX());
    const Eigen::MatrixXd across =
        motion(model, with(card(), {{"centre_of_pressure", cop}}), about_x, {0.2, 0.5, 1.0}, 1e-9);
    for (const int i : {0, 5, 6, 7, 11, 12}) CHECK(across.col(i).cwiseAbs().maxCoeff() == 0.0);
  }
}

TEST_CASE("the force terms sum to the rate of momentum and their powers to the rate of energy") {
  std::mt19937 random(5);
  const auto wind = find_model("immersed_body_in_wind");
  const Values values = with(card(), {{"r_bx", 0.002},
                                      {"r_bz", 0.001},
                                      {"centre_of_pressure", 0.5},
                                      {"kappa", 0.7},
                                      {"speed_floor", 0.02},
                                      {"rate_floor", 1.0},
                                      {"wind_x", 1.3},
                                      {"wind_y", -0.4},
                                      {"wind_z", 0.2}});
  const ParameterValues p = parameter_values(*wind, values);
  const Eigen::Vector3d w_air(1.3, -0.4, 0.2);
  const auto value = [&](const std::string& name, const char* axis) {
    return parameter(*wind, p, name + axis);
  };
  const double m = parameter(*wind, p, "mass");
  const Eigen::Vector3d mass(m + value("M_", "x"), m + value("M_", "y"), m + value("M_", "z"));
  const Eigen::Vector3d inertia(value("I_", "x") + value("J_", "x"), value("I_", "y") + value("J_", "y"),
                                value("I_", "z") + value("J_", "z"));
  for (int k = 0; k < 1000; ++k) {
    const BodyState state = random_state(random);
    const Eigen::VectorXd f = rhs(*wind, state, p);
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();
    double power = 0.0;
    double size = 0.0;
    double torque_size = 0.0;
    double power_size = 0.0;
    for (const Wrench& term : forces(*wind, state, p)) {
      force += term.force;
      torque += term.torque;
      power += term.power;
      size += term.force.norm();
      torque_size += term.torque.norm();
      power_size += term.force.norm() * state.u.norm() + term.torque.norm() * state.w.norm();
    }
    const Eigen::Vector3d u_air = state.R().transpose() * w_air;
    const Eigen::Vector3d u_r = state.u - u_air;
    // In a uniform wind d(R^T w_air)/dt = -w x R^T w_air.
    const Eigen::Vector3d u_r_rate = f.segment<3>(7) + state.w.cross(u_air);
    const Eigen::Vector3d w_rate = f.segment<3>(10);
    CHECK((mass.cwiseProduct(u_r_rate) - force).norm() <
          1e-14 * (size + 2.0 * m * state.w.norm() * u_air.norm()));
    CHECK((inertia.cwiseProduct(w_rate) - torque).norm() < 1e-14 * torque_size);
    const double energy_rate =
        u_r.dot(mass.cwiseProduct(u_r_rate)) + state.w.dot(inertia.cwiseProduct(w_rate));
    CHECK(std::abs(energy_rate - power) <
          1e-13 * (power_size + size * u_air.norm() + m * state.w.norm() * u_air.norm() * u_r.norm()));
    const double energy = *wind->kinetic_energy(0.0, state.vector(), p);
    CHECK_THAT(energy,
               WithinRel(0.5 * (u_r.dot(mass.cwiseProduct(u_r)) + state.w.dot(inertia.cwiseProduct(state.w))),
                         1e-13));
  }
}

TEST_CASE("what the body loses in energy along its way, the terms have taken") {
  // d/dt (kinetic energy) is the power of all terms: the energy that drag and damping take in, added to the
  // potential energy lost, is what remains. By Simpson's rule over 1 ms steps, smooth floors: error ~ 1e-8.
  const auto model = find_model("immersed_body");
  const Values values = with(card(), {{"speed_floor", 0.02}, {"rate_floor", 1.0}, {"damping_isotropy", 1.0}});
  const ParameterValues p = parameter_values(*model, values);
  BodyState start;
  start.q = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1.0, 0.4, 0.0).normalized());
  std::vector<double> times;
  const int steps = 400;
  for (int k = 0; k <= steps; ++k) times.push_back(1e-3 * k);
  const Eigen::MatrixXd states = motion(model, values, start, times);
  double work = 0.0;
  for (int k = 0; k <= steps; ++k) {
    double power = 0.0;
    for (const Wrench& term : forces(*model, BodyState(states.row(k)), p)) power += term.power;
    const double weight = k == 0 || k == steps ? 1.0 : (k % 2 == 1 ? 4.0 : 2.0);
    work += weight * power * 1e-3 / 3.0;
  }
  const BodyState end(states.row(steps));
  const double gained =
      *model->kinetic_energy(0.0, end.vector(), p) - *model->kinetic_energy(0.0, start.vector(), p);
  const double fallen = parameter(*model, p, "mass") * 9.81 * -end.position.z();
  CHECK(std::abs(gained - work) < 1e-6 * fallen);
  CHECK(gained < fallen);
}

TEST_CASE("f is affine in the coefficients, all together") {
  std::mt19937 random(17);
  for (const char* name : {"immersed_body", "immersed_body_in_wind"}) {
    const auto model = find_model(name);
    const Values values =
        with(card(),
             {{"centre_of_pressure", 1.0}, {"Re_drag", 50.0}, {"linear_damping_z", 1e-7}, {"Re_lift", 20.0}});
    const ParameterValues p = parameter_values(*model, values);
    for (int k = 0; k < 20; ++k) {
      const BodyState state = random_state(random);
      const AffineSplit split = affine_split(*model, 0.0, state.vector(), p);
      REQUIRE(split.names.size() == 8);
      Eigen::VectorXd sum = split.constant;
      double size = split.constant.cwiseAbs().maxCoeff();
      for (std::size_t j = 0; j < split.names.size(); ++j) {
        const Eigen::VectorXd part =
            parameter(*model, p, split.names[j]) * split.slopes.col(static_cast<Eigen::Index>(j));
        sum += part;
        size = std::max(size, part.cwiseAbs().maxCoeff());
      }
      CHECK((sum - rhs(*model, state, p)).cwiseAbs().maxCoeff() < 1e-14 * size);
    }
  }
}

TEST_CASE("turning the world about the vertical turns the motion of the immersed body with it") {
  const auto model = find_model("immersed_body");
  const ParameterValues p = parameter_values(*model, card());
  std::mt19937 random(23);
  for (int k = 0; k < 100; ++k) {
    const BodyState state = random_state(random);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.1 * k, Eigen::Vector3d::UnitZ()));
    BodyState turned = state;
    turned.position = turn * state.position;
    turned.q = turn * state.q;
    const Eigen::VectorXd f = rhs(*model, state, p);
    const Eigen::VectorXd g = rhs(*model, turned, p);
    CHECK((g.tail<6>() - f.tail<6>()).norm() < 1e-13 * f.tail<6>().norm());
    CHECK((g.head<3>() - turn * f.head<3>()).norm() < 1e-14 * f.head<3>().norm());
    const Eigen::Quaterniond rate(f[3], f[4], f[5], f[6]);
    CHECK(((turn * rate).coeffs() - Eigen::Quaterniond(g[3], g[4], g[5], g[6]).coeffs()).norm() <
          1e-14 * rate.norm());
  }
}

TEST_CASE("a bottom-heavy body swings back and a top-heavy one turns over") {
  // A neutrally buoyant ellipsoid whose centre of buoyancy lies 5 mm above or below its centre of mass.
  const auto model = find_model("immersed_body");
  for (const double r_bz : {0.005, -0.005}) {
    const Values values = {
        {"a", 0.05},   {"b", 0.05}, {"c", 0.05}, {"density", 1000.0}, {"fluid_density", 1000.0},
        {"r_bz", r_bz}};
    BodyState start;
    start.q = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX());
    std::vector<double> times;
    for (int k = 1; k <= 100; ++k) times.push_back(0.02 * k);
    const Eigen::MatrixXd states = motion(model, values, start, times, 1e-9);
    double least_up = 1.0;
    for (Eigen::Index k = 0; k < states.rows(); ++k) {
      least_up = std::min(least_up, BodyState(states.row(k)).R()(2, 2));
    }
    if (r_bz > 0.0) {
      CHECK(least_up > std::cos(0.1001));
    } else {
      CHECK(least_up < -0.5);
    }
  }
}
