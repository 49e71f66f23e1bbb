#include <numbers>

#include <catch2/catch.hpp>

#include "bodies_in_flow.h"
#include "samara/models/check_model.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

using Values = std::map<std::string, double>;

/// The card of the check values: 7 cm x 4 cm x 0.2 mm, semi-axes halves of that.
Values card() {
  return {{"a", 0.035},    {"b", 0.02},           {"c", 1e-4},          {"density", 1200.0},
          {"C_D90", 0.61}, {"C_D0", 0.05},        {"C_T", 1.81},        {"C_R", 1.21},
          {"C_w", 2.0},    {"speed_floor", 1e-9}, {"rate_floor", 1e-9}, {"damping_isotropy", 0.0}};
}

Values with(Values values, const Values& more) {
  for (const auto& [name, value] : more) values[name] = value;
  return values;
}

std::vector<Wrench> forces(const Model& model, const BodyState& state, const ParameterValues& p) {
  std::vector<Wrench> terms(model.info().force_terms.size());
  model.forces(0.0, state.vector(), p, terms);
  return terms;
}

enum Term { kInertia, kDrag, kTranslationalLift, kRotationalLift, kDamping, kGravity, kAmbient };

Eigen::VectorXd rhs(const Model& model, const BodyState& state, const ParameterValues& p) {
  Eigen::VectorXd f(13);
  model.rhs(0.0, state.vector(), p, {f.data(), 13});
  return f;
}

BodyState random_state(std::mt19937& random) {
  BodyState state;
  state.position = random_vector(random, 1.0);
  state.q = random_attitude(random);
  state.u = random_vector(random, 1.5);
  state.w = random_vector(random, 30.0);
  return state;
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

TEST_CASE("the immersed card reaches the reference state at 0.3 s") {
  BodyState start;
  start.q = {std::cos(0.15), std::sin(0.15) * std::cos(0.6), std::sin(0.15) * std::sin(0.6), 0.0};
  start.u = {0.05, 0.05, -0.1};
  start.w = {1.0, 2.0, 3.0};
  const Eigen::MatrixXd states = motion(find_model("immersed_body"), card(), start, {0.3});
  const BodyState end(states.row(0));
  const double scatter = 1e-7;
  const Eigen::Vector3d x = {0.010662110421, -0.024859850787, -0.326721668383};
  const Eigen::Vector3d u = {1.595843879144, -0.010333922442, -1.092395691472};
  const Eigen::Vector3d w = {40.8267535055, -2.1644425981, 14.3270031910};
  CHECK((end.position - x).norm() < scatter * x.norm());
  CHECK((end.u - u).norm() < scatter * u.norm());
  CHECK((end.w - w).norm() < scatter * w.norm());
  CHECK_THAT(end.q.norm(), WithinAbs(1.0, 1e-9));
}

TEST_CASE("drag and lift on a section are those of the planar law") {
  // A = pi a b and l = 2a, so the force over A/l is that of the planar law with the chord 2a, whose axes are
  // (body x, body z) and whose rotation is -w_y.
  const auto model = find_model("immersed_body");
  const Values values = card();
  const ParameterValues p = parameter_values(*model, values);
  BodyState state;
  state.u = {0.7, 0.0, -0.4};
  state.w = {0.0, 3.0, 0.0};
  const auto terms = forces(*model, state, p);
  const Eigen::Vector3d force =
      terms[kDrag].force + terms[kTranslationalLift].force + terms[kRotationalLift].force;
  const double span = std::numbers::pi * 0.035 * 0.02 / 0.07;
  CHECK_THAT(force.x() / span, WithinAbs(0.0123998254911338, 1e-15));
  CHECK_THAT(force.y() / span, WithinAbs(0.0, 1e-16));
  CHECK_THAT(force.z() / span, WithinAbs(0.0320359121556903, 1e-15));

  // The same from the planar law, with the circulation G and v_perp = (-vy, vx).
  const double a = 0.035, vx = 0.7, vy = -0.4, w = -3.0, v = std::hypot(vx, vy), rho = 1.2;
  const double G = -2.0 * 1.81 * a * vx * vy / v + 2.0 * 1.21 * a * a * w;
  const double A = (0.05 + 0.61) / 2.0, B = (0.61 - 0.05) / 2.0;
  const double D = rho * a * (A - B * (vx * vx - vy * vy) / (v * v)) * v;
  CHECK_THAT(force.x() / span, WithinAbs(-rho * G * vy - D * vx, 1e-15));
  CHECK_THAT(force.z() / span, WithinAbs(rho * G * vx - D * vy, 1e-15));
}

TEST_CASE("the damping torque of rotation about one axis is the planar one with mu2 = C_w / (4 pi)") {
  // Per unit span the planar law damps with pi rho a^4 mu2 |w| w. Over an elliptic outline the chord at y is
  // a(y) = a sqrt(1 - y^2/b^2), and the integral of a(y)^4 dy is 16/15 a^4 b, so that the torque is
  // 16/15 b a^4 pi rho mu2 |w| w = 1/2 rho C_w 8/15 b a^4 |w| w for mu2 = C_w / (4 pi).
  const auto model = find_model("immersed_body");
  const double mu2 = 0.2;
  for (const double isotropy : {0.0, 0.4, 1.0}) {
    const ParameterValues p = parameter_values(
        *model, with(card(), {{"C_w", 4.0 * std::numbers::pi * mu2}, {"damping_isotropy", isotropy}}));
    BodyState state;
    state.w = {0.0, 7.0, 0.0};
    const double expected = -16.0 / 15.0 * 0.02 * std::pow(0.035, 4) * std::numbers::pi * 1.2 * mu2 * 49.0;
    CHECK_THAT(forces(*model, state, p)[kDamping].torque.y(), WithinRel(expected, 1e-14));
    state.w = {7.0, 0.0, 0.0};
    const double about_x = -16.0 / 15.0 * 0.035 * std::pow(0.02, 4) * std::numbers::pi * 1.2 * mu2 * 49.0;
    CHECK_THAT(forces(*model, state, p)[kDamping].torque.x(), WithinRel(about_x, 1e-14));
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

TEST_CASE("the quasi-steady terms never do work on the body") {
  const auto model = find_model("immersed_body");
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int set = 0; set < 100; ++set) {
    Values values;
    for (const char* name : {"C_D0", "C_D90", "C_T", "C_R", "C_w"}) values[name] = 4.0 * uniform(random);
    values["damping_isotropy"] = uniform(random);
    values["centre_of_pressure"] = set % 2 == 0 ? 0.0 : 1.0;
    values["Re_drag"] = set % 3 == 0 ? 100.0 : 0.0;
    values["Re_lift"] = set % 5 == 0 ? 100.0 : 0.0;
    values["speed_floor"] = set % 7 == 0 ? 1e-9 : 0.02;
    const ParameterValues p = parameter_values(*model, with(card(), values));
    double worst = -1.0;
    double perpendicular = 0.0;
    for (int k = 0; k < 10000; ++k) {
      const auto terms = forces(*model, random_state(random), p);
      double power = 0.0;
      double round_off = 0.0;
      for (const int term : {kDrag, kTranslationalLift, kRotationalLift, kDamping}) {
        power += terms[static_cast<std::size_t>(term)].power;
      }
      for (const int term : {kTranslationalLift, kRotationalLift}) {
        const Wrench& lift = terms[static_cast<std::size_t>(term)];
        // A lift does no work; what is left is the round-off of products of size force times speed.
        round_off += lift.force.norm() * 10.0 + lift.torque.norm() * 100.0;
        perpendicular = std::max(perpendicular, std::abs(lift.power) - 1e-15 * round_off);
      }
      worst = std::max(worst, power - 1e-15 * round_off);
    }
    CHECK(worst <= 0.0);
    CHECK(perpendicular <= 0.0);
  }
}

TEST_CASE("drag at the centre of pressure with the velocity of the centre of mass would do work") {
  // What the source does, for contrast: the passive form takes the velocity of that point.
  const auto model = find_model("immersed_body");
  const ParameterValues p = parameter_values(*model, with(card(), {{"centre_of_pressure", 1.0}}));
  const ParameterValues off = parameter_values(*model, card());
  std::mt19937 random(3);
  double greatest = 0.0;
  for (int k = 0; k < 10000; ++k) {
    const BodyState state = random_state(random);
    const auto at_p = forces(*model, state, p);
    const auto at_centre = forces(*model, state, off);
    const Eigen::Vector3d F = at_centre[kDrag].force + at_centre[kTranslationalLift].force;
    // The arm p from the torque about the normal's plane: p is tangential, F known.
    const Eigen::Vector3d drag = at_p[kDrag].force;
    if (std::abs(drag.z()) < 1e-6) continue;
    const Eigen::Vector3d arm(-at_p[kDrag].torque.y() / drag.z(), at_p[kDrag].torque.x() / drag.z(), 0.0);
    greatest = std::max(greatest, F.dot(state.u) + arm.cross(F).dot(state.w));
  }
  CHECK(greatest > 1e-3);
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

TEST_CASE("with a Reynolds number the drag turns linear at low speed and the lifts vanish") {
  const auto model = find_model("immersed_body");
  const Values values = with(card(), {{"Re_drag", 30.0}, {"Re_lift", 30.0}, {"nu", 1.5e-5}});
  const ParameterValues p = parameter_values(*model, values);
  const ParameterValues plain = parameter_values(*model, card());
  BodyState state;
  const Eigen::Vector3d direction(0.6, 0.0, -0.8);
  const auto at = [&](double speed, const ParameterValues& values_at) {
    state.u = speed * direction;
    return forces(*model, state, values_at);
  };
  // Re = 2 a |u| / nu = 4667 |u|/(m/s). Fast: the corrections are Re_drag/Re and Re_lift/Re.
  const double Re_of_100 = 0.07 * 100.0 / 1.5e-5;
  CHECK_THAT(at(100.0, p)[kDrag].force.norm(),
             WithinRel(at(100.0, plain)[kDrag].force.norm() * (1.0 + 30.0 / Re_of_100), 1e-13));
  CHECK_THAT(at(100.0, p)[kTranslationalLift].force.norm(),
             WithinRel(at(100.0, plain)[kTranslationalLift].force.norm() / (1.0 + 30.0 / Re_of_100), 1e-13));
  // Slow, Re = 5e-3 and 1e-2: twice the speed, twice the drag but for Re/Re_drag = 3e-4; eight times the
  // lift.
  const double slow = 1e-6;
  CHECK_THAT(at(2.0 * slow, p)[kDrag].force.norm() / at(slow, p)[kDrag].force.norm(), WithinRel(2.0, 1e-3));
  CHECK_THAT(
      at(2.0 * slow, p)[kTranslationalLift].force.norm() / at(slow, p)[kTranslationalLift].force.norm(),
      WithinRel(8.0, 1e-3));
}

TEST_CASE("damping does not depend on the axes chosen in a round disc") {
  const auto model = find_model("immersed_body");
  const ParameterValues p = parameter_values(*model, with(card(), {{"b", 0.035}, {"damping_isotropy", 1.0}}));
  BodyState state;
  state.w = {5.0, 0.0, 0.0};
  const double torque = forces(*model, state, p)[kDamping].torque.norm();
  for (const double angle : {0.3, 0.7, 1.1}) {
    state.w = {5.0 * std::cos(angle), 5.0 * std::sin(angle), 0.0};
    const Eigen::Vector3d turned = forces(*model, state, p)[kDamping].torque;
    CHECK_THAT(turned.norm(), WithinRel(torque, 1e-14));
    CHECK(turned.cross(state.w).norm() < 1e-14 * turned.norm() * state.w.norm());
  }
}
