// What check_model finds in models whose physics is broken in one place.
#include <algorithm>

#include <catch2/catch.hpp>

#include "function_model.h"
#include "samara/models/checks/check_model.h"

using namespace samara::models;

namespace {

using FunctionValues = FunctionModel::Values;

std::string findings(const Model& model) {
  std::string text;
  for (const std::string& finding : check_model(model).findings) text += finding + "\n";
  return text;
}

using Catch::Matchers::Contains;

/// A weight against linear drag: x' = v, mass v' = -weight - k v, with its forces and its energy.
FunctionModel falling(FunctionModel::Rates rates) {
  FunctionModel model(std::move(rates));
  model.add_state("x", "m");
  model.add_state("v", "m/s");
  model.add_parameter("mass", "kg");
  model.add_parameter("k", "N s/m");
  model.add_parameter("weight", "N");
  model.info_.symmetries = {"translation of x"};
  model.info_.affine_in = {"k", "weight"};
  model.info_.force_terms = {{.name = "drag"}, {.name = "weight"}};
  model.forces_ = [](const FunctionValues& x, const FunctionValues& p) {
    std::vector<Wrench> terms(2);
    terms[0].force.z() = -p[1] * x[1];
    terms[1].force.z() = -p[2];
    for (Wrench& term : terms) term.power = term.force.z() * x[1];
    return terms;
  };
  model.energy_ = [](const FunctionValues& x, const FunctionValues& p) { return 0.5 * p[0] * x[1] * x[1]; };
  return model;
}

FunctionValues falling_rates(const FunctionValues& x, const FunctionValues& p) {
  return {x[1], (-p[2] - p[1] * x[1]) / p[0]};
}

/// A point that goes ahead along the body's first axis while the body turns: quaternion and position.
FunctionValues gliding_rates(const FunctionValues& x, const FunctionValues& p) {
  const double w = x[0], i = x[1], j = x[2], k = x[3];
  const std::array<double, 3> spin = {0.3, -0.7, p[0]};  // body axes
  return {0.5 * (-i * spin[0] - j * spin[1] - k * spin[2]),
          0.5 * (w * spin[0] + j * spin[2] - k * spin[1]),
          0.5 * (w * spin[1] + k * spin[0] - i * spin[2]),
          0.5 * (w * spin[2] + i * spin[1] - j * spin[0]),
          w * w + i * i - j * j - k * k,
          2.0 * (i * j + w * k),
          2.0 * (i * k - w * j)};
}

FunctionModel gliding(FunctionModel::Rates rates) {
  FunctionModel model(std::move(rates));
  for (const char* name : {"q0", "q1", "q2", "q3", "x", "y", "z"}) model.add_state(name, "1");
  model.add_parameter("spin", "1");
  model.info_.symmetries = {"rotation about z"};
  model.info_.groups = {{StateGroupKind::quaternion, 0}, {StateGroupKind::position, 4}};
  return model;
}

}  // namespace

TEST_CASE("a weight against linear drag passes every check") {
  CHECK(findings(falling(falling_rates)).empty());
}

TEST_CASE("a constant that hides a unit is found with the unit it hides") {
  const std::string text = findings(falling([](const FunctionValues& x, const FunctionValues& p) {
    return FunctionValues{x[1], -9.81 - p[1] * x[1] / p[0]};
  }));
  CHECK_THAT(text,
             Contains("the rate of \"v\" does not follow its unit, \"m/s\" per s, when the unit of length"));
  CHECK_THAT(text, Contains("the unit of time"));
  CHECK_THAT(text, !Contains("the unit of mass"));
  CHECK_THAT(text, !Contains("the rate of \"x\""));
}

TEST_CASE("a model with numbers of its own may be checked for all but its units") {
  const FunctionModel model = falling([](const FunctionValues& x, const FunctionValues& p) {
    return FunctionValues{x[1], (-p[2] - p[1] * x[1]) / p[0] + std::sin(x[0])};
  });
  CHECK_THAT(findings(model), Contains("does not follow its unit"));
  FunctionModel without_forces = model;
  without_forces.info_.symmetries.clear();
  without_forces.energy_ = nullptr;
  CHECK(check_model(without_forces, {.units = false}).passed());
}

TEST_CASE("a parameter with a wrong unit is found by the dimension that is wrong") {
  FunctionModel model = falling(falling_rates);
  model.info_.parameters[1].unit = "N s^2/m";
  const std::string text = findings(model);
  CHECK_THAT(text, Contains("the rate of \"v\"") && Contains("the unit of time"));
  CHECK_THAT(text, !Contains("the unit of mass") && !Contains("the unit of length"));
}

TEST_CASE("a derived default that does not follow its unit is found") {
  FunctionModel model = falling(falling_rates);
  model.info_.parameters[2].derived = "mass";
  model.complete_ = [](const std::vector<char>& given, FunctionValues& p) {
    if (!given[2]) p[2] = p[0];
  };
  CHECK_THAT(findings(model), Contains("the derived default of \"weight\" does not follow its unit, \"N\""));
}

TEST_CASE("forces of a body that are said to be per metre of span are found") {
  FunctionModel model = falling(falling_rates);
  model.info_.per_span = true;
  const std::string text = findings(model);
  CHECK_THAT(text, Contains("the force of the term \"drag\" does not follow its unit, \"N/m\""));
  CHECK_THAT(text, Contains("the kinetic energy does not follow its unit, \"J/m\""));
  CHECK_THAT(text, !Contains("the unit of time"));
}

TEST_CASE("a force that is no number in other units is found") {
  FunctionModel model = falling(falling_rates);
  const FunctionModel::Forces forces = model.forces_;
  model.forces_ = [forces](const FunctionValues& x, const FunctionValues& p) {
    std::vector<Wrench> terms = forces(x, p);
    if (p[0] > 2.0) terms[0].torque.x() = std::nan("");  // no mass is drawn so large
    return terms;
  };
  CHECK_THAT(findings(model), Contains("the torque of the term \"drag\" does not follow its unit"));
}

TEST_CASE("a unit outside SI is found") {
  FunctionModel model = falling(falling_rates);
  model.info_.parameters[0].unit = "lb";
  CHECK_THAT(findings(model), Contains("unit \"lb\" of \"mass\" is not made of base units of SI"));
}

TEST_CASE("coefficients that do not enter linearly, all together, are found") {
  const auto with = [](FunctionModel::Rates rates) {
    FunctionModel model(std::move(rates));
    model.add_state("x", "1");
    model.add_parameter("a", "1");
    model.add_parameter("b", "1");
    model.info_.affine_in = {"a", "b"};
    return model;
  };
  const std::string words = "the rate of \"x\" is not affine in the parameters of affine_in";
  CHECK(findings(with([](const FunctionValues& x, const FunctionValues& p) {
          return FunctionValues{p[0] * x[0] - p[1] + 2.0};
        })).empty());
  CHECK_THAT(findings(with([](const FunctionValues& x, const FunctionValues& p) {
               return FunctionValues{p[0] * p[0] * x[0]};
             })),
             Contains(words));
  CHECK_THAT(findings(with([](const FunctionValues& x, const FunctionValues& p) {
               return FunctionValues{p[0] * p[1] * x[0]};
             })),
             Contains(words));
  FunctionModel model =
      with([](const FunctionValues& x, const FunctionValues& p) { return FunctionValues{p[0] * x[0]}; });
  model.info_.affine_in = {"a", "c"};
  CHECK_THAT(findings(model), Contains("affine in \"c\", which is no parameter"));
}

TEST_CASE("forces that do not add up to the rate of the energy are found") {
  const std::string words = "the powers of the force terms do not sum to the rate of the kinetic energy";
  FunctionModel forgotten = falling(falling_rates);
  const FunctionModel::Forces forces = forgotten.forces_;
  forgotten.forces_ = [forces](const FunctionValues& x, const FunctionValues& p) {
    std::vector<Wrench> terms = forces(x, p);
    terms[1].power = 0.0;
    return terms;
  };
  CHECK_THAT(findings(forgotten), Contains(words));
  FunctionModel heavier = falling(falling_rates);
  heavier.energy_ = [](const FunctionValues& x, const FunctionValues& p) {
    return 0.5001 * p[0] * x[1] * x[1];
  };
  CHECK_THAT(findings(heavier), Contains(words));
  heavier.energy_ = nullptr;  // without an energy there is no balance to check
  CHECK(findings(heavier).empty());
}

TEST_CASE("a term that gives the power it is said to take, or not to touch, is found") {
  FunctionModel model = falling(falling_rates);
  model.info_.force_terms[0].description = "against the velocity; takes power";
  CHECK(findings(model).empty());
  model.info_.force_terms[0].description = "no power";
  CHECK_THAT(findings(model), Contains("the force term \"drag\" is said to do no power, and gives -"));
  model.info_.force_terms[0].description.clear();
  model.info_.force_terms[1].description = "takes power";
  CHECK_THAT(findings(model), Contains("the force term \"weight\" is said to take power, and gives "));
}

TEST_CASE("a force or an energy that is not a number is found") {
  FunctionModel model = falling(falling_rates);
  const FunctionModel::Forces forces = model.forces_;
  model.energy_ = [](const FunctionValues&, const FunctionValues&) { return std::nan(""); };
  CHECK_THAT(findings(model), Contains("the kinetic energy is nan"));
  model.forces_ = [forces](const FunctionValues& x, const FunctionValues& p) {
    std::vector<Wrench> terms = forces(x, p);
    terms[0].torque.x() = std::nan("");
    return terms;
  };
  CHECK_THAT(findings(model), Contains("the force term \"drag\" is not finite"));
}

TEST_CASE("a body that knows no direction but the vertical turns with the world") {
  CHECK(findings(gliding(gliding_rates)).empty());
  FunctionModel vector = gliding(gliding_rates);
  vector.info_.groups[1].kind = StateGroupKind::vector;
  CHECK(findings(vector).empty());
}

TEST_CASE("a drift to the east is no symmetry about the vertical") {
  const FunctionModel model = gliding([](const FunctionValues& x, const FunctionValues& p) {
    FunctionValues rates = gliding_rates(x, p);
    rates[4] += 0.1;
    return rates;
  });
  CHECK_THAT(findings(model), Contains("symmetry \"rotation about z\" does not hold: the rate of \"x\""));
  FunctionModel modest = model;
  modest.info_.symmetries.clear();
  CHECK(findings(modest).empty());
}

TEST_CASE("a quaternion from world to body is found: it turns the other way") {
  const FunctionModel model = gliding([](const FunctionValues& x, const FunctionValues& p) {
    const FunctionValues inverse = {x[0], -x[1], -x[2], -x[3], x[4], x[5], x[6]};
    FunctionValues rates = gliding_rates(inverse, p);
    for (std::size_t i = 1; i < 4; ++i) rates[i] = -rates[i];
    return rates;
  });
  CHECK_THAT(findings(model), Contains("symmetry \"rotation about z\" does not hold"));
}

TEST_CASE("attitudes are tried at norm one, and a rate that changes the norm there is found") {
  const auto with_growth = [](auto growth) {
    return gliding([growth](const FunctionValues& x, const FunctionValues& p) {
      FunctionValues rates = gliding_rates(x, p);
      const double norm2 = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3];
      for (std::size_t i = 0; i < 4; ++i) rates[i] += growth(norm2) * x[i];
      return rates;
    });
  };
  CHECK(findings(with_growth([](double norm2) { return 1.0 - norm2; })).empty());
  CHECK_THAT(findings(with_growth([](double) { return 0.01; })),
             Contains("the norm of the quaternion from \"q0\" on changes along f"));
}

TEST_CASE("groups beyond the states, or sharing some, are found") {
  FunctionModel model = gliding(gliding_rates);
  model.info_.groups[1].first = 5;
  CHECK_THAT(findings(model), Contains("group 1 of states reaches from 5 to 7, beyond the states"));
  model.info_.groups[1].first = 3;
  CHECK_THAT(findings(model), Contains("state \"q3\" is in two groups"));
  model.info_.groups[1].first = -1;
  CHECK_THAT(findings(model), Contains("beyond the states"));
}
