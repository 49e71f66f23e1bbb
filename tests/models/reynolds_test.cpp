// Coefficients that follow the Reynolds number, in every law that has them.
#include <array>
#include <numbers>

#include <catch2/catch.hpp>

#include "bodies_in_flow.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinRel;

namespace {

using Values = std::map<std::string, double>;

/// A law, and a motion of it at speed 1 with a drag along the motion and, where it has one, a lift.
struct Case {
  std::string model;
  Values values;
  std::vector<double> unit_speed;  ///< states, at speed 1; times a speed, the states at that speed
  double Re;                       ///< at speed 1
  std::string lift;                ///< name of a term that is a lift, or empty
};

/// Coefficients are those of nu = 1e-3 m^2/s, floors so small that they do not count.
std::vector<Case> cases() {
  const double pi = std::numbers::pi;
  const Values plate = {{"density", 1200.0}, {"nu", 1e-3}, {"speed_floor", 1e-12}};
  const auto with = [](Values values, const Values& more) {
    values.insert(more.begin(), more.end());
    return values;
  };
  return {
      {"vertical_fall",
       {{"C_D", 1.2}, {"density", 1200.0}, {"area", pi * 0.01}, {"thickness", 1e-3}, {"nu", 1e-3}},
       {1.0, 0.0},
       200.0,
       ""},
      {"quadratic_drag_fall", {{"C_D", 1.2}, {"area", pi * 0.01}, {"nu", 1e-3}}, {1.0}, 200.0, ""},
      {"sphere_flight",
       {{"diameter", 0.04}, {"nu", 1e-3}, {"speed_floor", 1e-12}},
       {0.0, 0.0, 0.0, 0.6, 0.0, 0.8, 0.0, 0.0, 0.0},
       40.0,
       ""},
      {"falling_plate",
       with(plate, {{"semi_chord", 0.1}, {"semi_thickness", 1e-3}}),
       {0.6, -0.8, 0.0, 0.0, 0.0, 0.0},
       200.0,
       "translational lift"},
      {"falling_rectangle",
       with(plate, {{"chord", 0.1}, {"thickness", 1e-3}}),
       {0.6, -0.8, 0.0, 0.0, 0.0, 0.0},
       100.0,
       "translational lift"},
      {"falling_plate_nd",
       {{"Re", 200.0}, {"speed_floor", 1e-12}},
       {0.6, -0.8, 0.0, 0.0, 0.0, 0.0},
       200.0,
       "translational lift"},
      {"coefficient_body",
       {{"mass", 0.1},
        {"I_x", 0.01},
        {"I_y", 0.01},
        {"I_z", 0.01},
        {"area", 0.04},
        {"nu", 1e-3},
        {"Cd0", 0.2},
        {"Cla", 1.0},
        {"speed_floor", 1e-12}},
       {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.6, 0.0, 0.0, 0.0},
       200.0,
       "lift"},
      {"immersed_body",
       {{"a", 0.1}, {"b", 0.05}, {"c", 1e-3}, {"density", 1200.0}, {"nu", 1e-3}, {"speed_floor", 1e-12}},
       {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.0, -0.8, 0.0, 0.0, 0.0},
       200.0,
       "translational lift"},
  };
}

Eigen::Vector3d force(const Case& law, const std::string& term, double speed, double Re_drag,
                      double Re_lift) {
  const auto model = find_model(law.model);
  Values values = law.values;
  values["Re_drag"] = Re_drag;
  if (!law.lift.empty()) values["Re_lift"] = Re_lift;
  std::vector<double> x = law.unit_speed;
  for (double& value : x) value *= speed;
  if (x.size() == 13) x[3] = 1.0;  // the attitude
  const auto& names = model->info().force_terms;
  std::vector<Wrench> terms(names.size());
  model->forces(0.0, x, parameter_values(*model, values), terms);
  return terms[static_cast<std::size_t>(std::ranges::find(names, term, &ForceTermInfo::name) - names.begin())]
      .force;
}

}  // namespace

TEST_CASE("drag grows by Re_drag/Re and lift falls by Re_lift/Re, whatever the law") {
  for (const Case& law : cases()) {
    for (const double speed : {0.01, 1.0, 30.0}) {
      INFO(law.model << " at " << speed);
      const double Re = law.Re * speed;
      const Eigen::Vector3d drag = force(law, "drag", speed, 0.0, 0.0);
      REQUIRE(drag.norm() > 0.0);
      CHECK((force(law, "drag", speed, 24.0, 7.0) - (1.0 + 24.0 / Re) * drag).norm() <
            1e-13 * (1.0 + 24.0 / Re) * drag.norm());
      if (law.lift.empty()) continue;
      const Eigen::Vector3d lift = force(law, law.lift, speed, 0.0, 0.0);
      REQUIRE(lift.norm() > 0.0);
      CHECK((force(law, law.lift, speed, 24.0, 7.0) - lift / (1.0 + 7.0 / Re)).norm() < 1e-13 * lift.norm());
    }
  }
}

TEST_CASE("a small sphere with Re_drag = 24/C_D falls at the speed of Stokes") {
  // A steel ball of 0.2 mm in glycerine: Re about 1e-5, and the drag of 3 pi mu d v but for Re/Re_drag.
  const double d = 2e-4, rho = 7800.0, rho_f = 1260.0, mu = 1.4, g = 9.81, C_D = 0.45;
  const double pi = std::numbers::pi;
  const ParametricModel model(find_model("sphere_flight"),
                              {{"diameter", d},
                               {"mass", pi / 6.0 * rho * d * d * d},
                               {"fluid_density", rho_f},
                               {"C_D", C_D},
                               {"Re_drag", 24.0 / C_D},
                               {"nu", mu / rho_f},
                               {"speed_floor", 1e-9}},
                              {});
  const Trajectory trajectory = integrate(model, {}, std::array{0.05}, {.stiff = true});
  REQUIRE(trajectory.is_usable());
  CHECK_THAT(-trajectory.states(0, 5), WithinRel((rho - rho_f) * g * d * d / (18.0 * mu), 1e-5));
}
