#include "samara/models/interface/parametric_model.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <catch2/catch.hpp>

#include "falling_card.h"
#include "samara/base/errors.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;

namespace {

using Fixed = std::map<std::string, double>;
using Names = std::vector<std::string>;

ParametricModel fall(const Fixed& fixed, const Names& free) {
  return ParametricModel(find_model("vertical_fall"), fixed, free);
}

const Fixed kBody = {{"density", 2000.0}, {"area", 1e-3}, {"thickness", 1e-3}};

}  // namespace

TEST_CASE("free coordinates keep the order asked for, with unit and kind") {
  const ParametricModel model = fall(kBody, {"v(0)", "C_D", "m_a"});
  REQUIRE(model.free_count() == 3);
  CHECK(model.state_count() == 2);
  CHECK(model.free()[0].name == "v(0)");
  CHECK(model.free()[0].unit == "m/s");
  CHECK(model.free()[0].is_initial);
  CHECK(model.free()[0].index == 0);
  CHECK(model.free()[1].unit == "1");
  CHECK_FALSE(model.free()[1].is_initial);
  CHECK(model.free()[2].unit == "kg");
  CHECK(model.fixed() == kBody);
}

TEST_CASE("initial values are the default, the fixed or the free ones") {
  Fixed fixed = kBody;
  std::array<double, 2> x0;
  fall(fixed, {"C_D"}).initial(std::array{1.0}, x0);
  CHECK(x0 == std::array{0.0, 0.0});
  fixed["x(0)"] = -3.0;
  fall(fixed, {"C_D", "v(0)"}).initial(std::array{1.0, 0.5}, x0);
  CHECK(x0 == std::array{0.5, -3.0});
}

TEST_CASE("a state starts at the value that is held of its start, else at its default") {
  const StateInfo state{.name = "theta", .unit = "rad", .default_initial = 0.4};
  CHECK(held_start(state, {{"theta", 3.0}}) == 0.4);
  CHECK(held_start(state, {{"theta(0)", -1.0}}) == -1.0);
}

TEST_CASE("parameters are completed by defaults and the free values") {
  const std::vector<double> p = fall(kBody, {"m_a", "C_D"}).parameters(std::array{0.25, 1.5});
  const double length = 2.0 * std::sqrt(1e-3 / std::numbers::pi);
  CHECK(p == std::vector<double>{1.5, 2000.0, 998.2, 1e-3, 1e-3, 0.25, 9.81, 0.0, 1.004e-6, length});
}

TEST_CASE("the derivative by an initial value is zero in the right-hand side, and others find their column") {
  const ParametricModel model = fall(kBody, {"x(0)", "g", "C_D"});
  ParametricModel::Workspace workspace = model.make_workspace();
  RhsDerivatives derivatives;
  std::array<double, 2> f, plain;
  const std::array q = {0.0, 9.0, 1.2};
  const std::array x = {0.4, 1.0};
  model.rhs_with_derivatives(0.0, x, q, f, derivatives, workspace);
  model.rhs(0.0, x, q, plain, workspace);
  CHECK(f == plain);
  REQUIRE(derivatives.df_dq.cols() == 3);
  CHECK(derivatives.df_dq.col(0).isZero(0.0));
  // dv'/dg = (m - m_f)/(m + m_a) = (v' + drag)/g, and drag is -C_D dv'/dC_D.
  const double by_C_D = derivatives.df_dq(0, 2);
  CHECK_THAT(derivatives.df_dq(0, 1), Catch::Matchers::WithinRel((f[0] - 1.2 * by_C_D) / 9.0, 1e-13));
  CHECK(by_C_D < 0.0);
  CHECK(derivatives.df_dx(1, 0) == 1.0);
}

TEST_CASE("a workspace of another parametric model does no harm") {
  const ParametricModel one = fall(kBody, {"C_D"});
  const ParametricModel other =
      fall({{"density", 500.0}, {"area", 2e-3}, {"thickness", 1e-3}, {"C_D", 3.0}}, {});
  ParametricModel::Workspace own = one.make_workspace();
  ParametricModel::Workspace shared = other.make_workspace();
  std::array<double, 2> expected, found;
  const std::array x = {0.1, 0.0};
  other.rhs(0.0, x, {}, found, shared);
  one.rhs(0.0, x, std::array{1.0}, found, shared);
  one.rhs(0.0, x, std::array{1.0}, expected, own);
  CHECK(found == expected);
}

TEST_CASE("an unknown name suggests the nearest, parameters and initial values alike") {
  CHECK_THROWS_AS(fall(kBody, {"C_d"}), samara::ArgumentError);
  CHECK_THROWS_WITH(
      fall(kBody, {"C_d"}),
      "model \"vertical_fall\" has no parameter or initial value \"C_d\"; did you mean \"C_D\"?");
  CHECK_THROWS_WITH(
      fall({{"tickness", 1.0}}, {}),
      "model \"vertical_fall\" has no parameter or initial value \"tickness\"; did you mean \"thickness\"?");
  CHECK_THROWS_WITH(fall(kBody, {"w(0)"}), Catch::Contains("did you mean \"v(0)\"?"));
  CHECK_THROWS_WITH(
      fall(kBody, {"viscosity"}),
      Catch::Contains(
          "; known: C_D, density, fluid_density, area, thickness, m_a, g, Re_drag, nu, length, v(0), x(0)"));
}

TEST_CASE("a name is fixed or free, and free once") {
  CHECK_THROWS_WITH(fall(kBody, {"C_D", "density"}),
                    "\"density\" is both fixed, at 2000 kg/m^3, and free; one of the two was expected");
  CHECK_THROWS_WITH(fall(kBody, {"C_D", "C_D"}),
                    "\"C_D\" is listed twice among the free coordinates; once was expected");
}

TEST_CASE("a fixed value must be finite and within its meaning") {
  Fixed fixed = kBody;
  fixed["C_D"] = -0.5;
  CHECK_THROWS_WITH(fall(fixed, {}), "\"C_D\" is -0.5; a value >= 0 was expected");
  fixed["C_D"] = 0.0;
  CHECK_NOTHROW(fall(fixed, {}));
  fixed["area"] = 0.0;
  CHECK_THROWS_WITH(fall(fixed, {}), "\"area\" is 0 m^2; a value > 0 m^2 was expected");
  fixed = {{"x(0)", std::numeric_limits<double>::infinity()}};
  CHECK_THROWS_WITH(fall(fixed, {}), "\"x(0)\" is inf; a finite number was expected");
}

TEST_CASE("required parameters that are neither fixed nor free are named, all of them") {
  CHECK_THROWS_WITH(fall(kBody, {}),
                    "model \"vertical_fall\" needs a value of \"C_D\"; give it, or leave it free");
  CHECK_THROWS_WITH(
      fall({{"C_D", 1.0}}, {"area"}),
      "model \"vertical_fall\" needs a value of \"density\" [kg/m^3], \"thickness\" [m]; give it, or "
      "leave it free");
}

TEST_CASE("a parametric model without a model is refused") {
  CHECK_THROWS_AS(ParametricModel(nullptr, {}, {}), samara::ArgumentError);
}

TEST_CASE("free values are checked by name") {
  const ParametricModel model = fall(kBody, {"C_D", "v(0)"});
  CHECK_NOTHROW(model.check(std::array{1.0, -2.0}));
  CHECK_THROWS_WITH(model.check(std::array{-1.0, 0.0}), "\"C_D\" is -1; a value >= 0 was expected");
  CHECK_THROWS_WITH(model.check(std::array{1.0, std::numeric_limits<double>::quiet_NaN()}),
                    "\"v(0)\" is nan; a finite number was expected");
  CHECK_THROWS_WITH(model.check(std::array{1.0}),
                    "1 values were given for the 2 free coordinates (C_D, v(0))");
}

TEST_CASE("what no single parameter shows is refused too: shares above one, inertia that is none") {
  const auto card = find_model("immersed_body");
  const std::map<std::string, double> fixed = {{"a", 0.035}, {"b", 0.02}, {"c", 1e-4}, {"density", 1200.0}};
  std::map<std::string, double> twice = fixed;
  twice["kappa"] = 7.0;
  CHECK_THROWS_WITH(ParametricModel(card, twice, {}), "\"kappa\" is 7; a value from 0 to 1 was expected");
  std::map<std::string, double> nowhere = fixed;
  nowhere["qw(0)"] = 0.0;
  CHECK_THROWS_WITH(ParametricModel(card, nowhere, {}).check({}),
                    Catch::Contains("initial quaternion") && Catch::Contains("\"qw(0)\""));
  CHECK_NOTHROW(ParametricModel(card, fixed, {}).check({}));
  const auto body = find_model("kirchhoff_body");
  const std::map<std::string, double> box = {{"mass", 1.0}, {"I_xx", 1.0}, {"I_yy", 1.0}, {"I_zz", 1.0}};
  CHECK_NOTHROW(ParametricModel(body, box, {}).check({}));
  for (const char* entry : {"I_xy", "K_12"}) {
    std::map<std::string, double> indefinite = box;
    indefinite[entry] = 100.0;
    CHECK_THROWS_WITH(ParametricModel(body, indefinite, {}).check({}), Catch::Contains("positive definite"));
  }
}

TEST_CASE("derivatives by the free coordinates are those by all parameters, derived defaults included") {
  // "a" moves mass, inertia and added mass; "C_T" nothing but itself; more directions than one pass carries.
  const ParametricModel card = falling_card({"a", "ux(0)", "C_T", "density", "fluid_density", "b"});
  std::map<std::string, double> fixed = card_values();
  for (const FreeCoordinate& coordinate : card.free()) fixed.erase(coordinate.name);
  std::vector<std::string> names;
  for (const FreeCoordinate& coordinate : card.free()) names.push_back(coordinate.name);
  // The same without the derivatives in parts.
  const ParametricModel plain(std::make_shared<PlainModel>(card.shared_model()), fixed, names);
  ParametricModel::Workspace workspace = card.make_workspace(), plain_workspace = plain.make_workspace();
  RhsDerivatives derivatives, plain_derivatives;
  std::vector<double> x(13), f(13), plain_f(13);
  for (const std::vector<double>& q :
       {std::vector{0.035, 0.05, 1.8, 1200.0, 1.2, 0.02}, std::vector{0.045, 0.07, 1.2, 900.0, 1.1, 0.03}}) {
    card.initial(q, x);
    card.rhs_with_derivatives(0.0, x, q, f, derivatives, workspace);
    plain.rhs_with_derivatives(0.0, x, q, plain_f, plain_derivatives, plain_workspace);
    CHECK(f == plain_f);
    CHECK(derivatives.df_dx == plain_derivatives.df_dx);
    for (Eigen::Index j = 0; j < 6; ++j) {
      const Eigen::VectorXd column = derivatives.df_dq.col(j);
      const Eigen::VectorXd expected = plain_derivatives.df_dq.col(j);
      INFO(names[static_cast<std::size_t>(j)]);
      CHECK((column - expected).norm() <= 1e-13 * expected.norm());
    }
    CHECK(derivatives.df_dq.col(1).isZero());
    CHECK(!derivatives.df_dq.col(0).isZero());
    // Forces grow with the fluid's density and the mass does not: a slope of the whole, by differences.
    const double h = 1e-6 * q[4];
    std::vector<double> above = q, below = q, f_above(13), f_below(13);
    above[4] += h;
    below[4] -= h;
    card.rhs(0.0, x, above, f_above, workspace);
    card.rhs(0.0, x, below, f_below, workspace);
    for (std::size_t i = 7; i < 13; ++i) {
      const double slope = (f_above[i] - f_below[i]) / (2.0 * h);
      CHECK(derivatives.df_dq(static_cast<Eigen::Index>(i), 4) == Approx(slope).epsilon(1e-6).margin(1e-6));
    }
  }
}
