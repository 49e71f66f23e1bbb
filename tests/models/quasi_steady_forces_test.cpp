#include <numbers>

#include <catch2/catch.hpp>

#include "immersed_card.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

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
  CHECK_THAT(force.x() / span, WithinAbs(0.0123998254911338, 1e-16));
  CHECK_THAT(force.y() / span, WithinAbs(0.0, 1e-16));
  CHECK_THAT(force.z() / span, WithinAbs(0.0320359121556903, 1e-16));

  // The same from the planar law, with the circulation G and v_perp = (-vy, vx).
  const double a = 0.035, vx = 0.7, vy = -0.4, w = -3.0, v = std::hypot(vx, vy), rho = 1.2;
  const double G = -2.0 * 1.81 * a * vx * vy / v + 2.0 * 1.21 * a * a * w;
  const double A = (0.05 + 0.61) / 2.0, B = (0.61 - 0.05) / 2.0;
  const double D = rho * a * (A - B * (vx * vx - vy * vy) / (v * v)) * v;
  CHECK_THAT(force.x() / span, WithinAbs(-rho * G * vy - D * vx, 1e-16));
  CHECK_THAT(force.z() / span, WithinAbs(rho * G * vx - D * vy, 1e-16));
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

TEST_CASE("the quasi-steady terms never do work on the body") {
  const auto model = find_model("immersed_body");
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int set = 0; set < 100; ++set) {
    Values values;
    for (const char* name : {"C_D0", "C_D90", "C_T", "C_R", "C_w"}) values[name] = 4.0 * uniform(random);
    values["damping_isotropy"] = uniform(random);
    values["velocity_chord"] = set % 4 == 0 ? 1.0 : uniform(random);
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

TEST_CASE("the rotational lift is the sum of the planar ones about the two axes of the plate") {
  const auto model = find_model("immersed_body");
  const ParameterValues p = parameter_values(*model, card());
  const auto lift = [&](const Eigen::Vector3d& u, const Eigen::Vector3d& w) {
    BodyState state;
    state.u = u;
    state.w = w;
    return Eigen::Vector3d(forces(*model, state, p)[kRotationalLift].force);
  };
  std::mt19937 random(31);
  for (int k = 0; k < 100; ++k) {
    const Eigen::Vector3d u = random_vector(random, 1.5), w = random_vector(random, 30.0);
    const double half = 0.5 * 1.2 * std::numbers::pi * 0.035 * 0.02 * 1.21;
    const Eigen::Vector3d expected = half * (2.0 * 0.02 * w.x() * Eigen::Vector3d::UnitX().cross(u) +
                                             2.0 * 0.035 * w.y() * Eigen::Vector3d::UnitY().cross(u));
    CHECK((lift(u, w) - expected).norm() <= 1e-14 * expected.norm());
  }
}

TEST_CASE("either chord of the rotational lift is the plate's where the motion is planar") {
  const auto model = find_model("immersed_body");
  const ParameterValues by_axis = parameter_values(*model, card());
  const ParameterValues by_velocity = parameter_values(*model, with(card(), {{"velocity_chord", 1.0}}));
  BodyState state;
  for (const bool about_y : {true, false}) {
    state.u = about_y ? Eigen::Vector3d(0.7, 0.0, -0.4) : Eigen::Vector3d(0.0, 0.7, -0.4);
    state.w = about_y ? Eigen::Vector3d(0.0, 3.0, 0.0) : Eigen::Vector3d(3.0, 0.0, 0.0);
    const Eigen::Vector3d one = forces(*model, state, by_axis)[kRotationalLift].force;
    const Eigen::Vector3d other = forces(*model, state, by_velocity)[kRotationalLift].force;
    CHECK((one - other).norm() <= 1e-14 * one.norm());
  }
}

TEST_CASE("the rotational lift of a round disc turns with its motion") {
  const auto model = find_model("immersed_body");
  const ParameterValues p = parameter_values(*model, with(card(), {{"b", 0.035}}));
  std::mt19937 random(37);
  for (int k = 0; k < 20; ++k) {
    const Eigen::AngleAxisd turn(0.3 * k, Eigen::Vector3d::UnitZ());
    BodyState state, turned;
    state.u = random_vector(random, 1.5);
    state.w = random_vector(random, 30.0);
    turned.u = turn * state.u;
    turned.w = turn * state.w;
    const Eigen::Vector3d lift = forces(*model, state, p)[kRotationalLift].force;
    CHECK((forces(*model, turned, p)[kRotationalLift].force - turn * lift).norm() <= 1e-14 * lift.norm());
  }
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

TEST_CASE(
    "a chord along the velocity stays between the axes of the outline where the tangential velocity "
    "vanishes") {
  // Rotational lift is 1/2 rho A l C_R |w x u|.
  const auto model = find_model("immersed_body");
  for (const double floor : {1e-9, 0.02}) {
    const ParameterValues p =
        parameter_values(*model, with(card(), {{"speed_floor", floor}, {"velocity_chord", 1.0}}));
    for (const double angle : {0.0, 0.4, 1.2, std::numbers::pi / 2.0}) {
      for (const double tangential : {0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0}) {
        BodyState state;
        state.u = {tangential * std::cos(angle), tangential * std::sin(angle), -1.0};
        state.w = {0.0, 1.0, 0.0};
        const double area = std::numbers::pi * 0.035 * 0.02;
        const double chord = forces(*model, state, p)[kRotationalLift].force.norm() /
                             (0.5 * 1.2 * area * 1.21 * state.w.cross(state.u).norm());
        CHECK(chord > 0.04 * (1.0 - 1e-14));
        CHECK(chord < 0.07 * (1.0 + 1e-14));
        if (tangential == 0.0) CHECK_THAT(chord, WithinRel(2.0 * std::sqrt(0.035 * 0.02), 1e-14));
        if (tangential == 1.0) {
          const double exact =
              2.0 * 0.035 * 0.02 / std::hypot(0.02 * std::cos(angle), 0.035 * std::sin(angle));
          CHECK_THAT(chord, WithinRel(exact, 2.0 * floor * floor + 1e-14));
        }
      }
    }
  }
}
