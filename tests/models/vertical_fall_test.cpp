#include <array>
#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "accuracy.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// A body like a coin, and the constants of its exact motion M v' = W - D |v| v.
struct Coin {
  double C_D = 1.15;
  double density = 6339.0;
  double fluid_density = 998.2;
  double area = 4.714e-4;
  double thickness = 2.55e-3;

  double m_a() const { return 8.0 / 3.0 * fluid_density * std::pow(area / std::numbers::pi, 1.5); }
  double M() const { return density * area * thickness + m_a(); }
  double W() const { return (density - fluid_density) * area * thickness * 9.81; }
  double D() const { return 0.5 * fluid_density * C_D * area; }
  double terminal() const { return std::sqrt(std::abs(W()) / D()); }
  double tau() const { return terminal() * M() / std::abs(W()); }
  double length() const { return terminal() * tau(); }

  std::map<std::string, double> fixed() const {
    return {{"C_D", C_D},   {"density", density},     {"fluid_density", fluid_density},
            {"area", area}, {"thickness", thickness}, {"g", 9.81}};
  }
};

struct Motion {
  double v, x;
};

/// Integrates from v(0) = v0 over eight times tau and compares with the exact motion.
template <class Exact>
void check_motion(const Coin& coin, double v0, Exact exact) {
  const ParametricModel model(find_model("vertical_fall"), coin.fixed(), {"v(0)"});
  std::vector<double> times;
  for (int k = 0; k <= 80; ++k) times.push_back(0.1 * k * coin.tau());
  for (const bool stiff : {false, true}) {
    const IntegrateOptions options = {.stiff = stiff};
    const Trajectory trajectory = integrate(model, std::array{v0}, times, options);
    REQUIRE(trajectory.is_usable());
    // x carries along the errors of v, eight tau long at most.
    const double largest = std::max(std::abs(v0) / coin.terminal(), 1.0);
    const double bound_v = promised(trajectory, 1e-10, largest * coin.terminal());
    const double bound_x =
        promised(trajectory, 1e-10, 8.0 * largest * coin.length()) + 8.0 * coin.tau() * bound_v;
    for (Eigen::Index row = 0; row < trajectory.times.size(); ++row) {
      const Motion motion = exact(trajectory.times[row]);
      CHECK_THAT(trajectory.states(row, 0), WithinAbs(motion.v, bound_v));
      CHECK_THAT(trajectory.states(row, 1), WithinAbs(motion.x, bound_x));
    }
  }
}

}  // namespace

TEST_CASE("a fall from rest follows v = v_T tanh(t/tau)") {
  const Coin coin;
  check_motion(coin, 0.0, [&](double t) {
    const double s = t / coin.tau();
    return Motion{coin.terminal() * std::tanh(s), coin.length() * std::log(std::cosh(s))};
  });
}

TEST_CASE("a fall from above the terminal speed follows v = v_T coth(t/tau + c)") {
  const Coin coin;
  const double v0 = 3.0 * coin.terminal();
  const double c = std::atanh(coin.terminal() / v0);
  check_motion(coin, v0, [&](double t) {
    const double s = t / coin.tau() + c;
    return Motion{coin.terminal() / std::tanh(s), coin.length() * std::log(std::sinh(s) / std::sinh(c))};
  });
}

TEST_CASE("a launch upward turns round at tau atan(|v0|/v_T) and then falls from rest") {
  const Coin coin;
  const double v0 = -2.0 * coin.terminal();
  // Upward both forces point down: M v' = W + D v^2, so v = v_T tan(t/tau - phi) until v = 0.
  const double phi = std::atan(-v0 / coin.terminal());
  const double x_turn = coin.length() * std::log(std::cos(phi));
  check_motion(coin, v0, [&](double t) {
    const double s = t / coin.tau() - phi;
    if (s < 0.0) {
      return Motion{coin.terminal() * std::tan(s), coin.length() * std::log(std::cos(phi) / std::cos(s))};
    }
    return Motion{coin.terminal() * std::tanh(s), x_turn + coin.length() * std::log(std::cosh(s))};
  });

  const ParametricModel model(find_model("vertical_fall"), coin.fixed(), {"v(0)"});
  const Trajectory turn = integrate(model, std::array{v0}, std::array{phi * coin.tau()});
  CHECK_THAT(turn.states(0, 0), WithinAbs(0.0, promised(turn, 1e-10, 2.0 * coin.terminal())));
  CHECK_THAT(turn.states(0, 1), WithinAbs(x_turn, promised(turn, 1e-10, 2.0 * coin.length())));
}

TEST_CASE("without drag the acceleration is uniform") {
  Coin coin;
  coin.C_D = 0.0;
  const ParametricModel model(find_model("vertical_fall"), coin.fixed(), {"v(0)", "x(0)"});
  const double v0 = -0.3;
  const double x0 = 0.1;
  const Trajectory trajectory = integrate(model, std::array{v0, x0}, std::array{0.1, 0.5, 1.0});
  REQUIRE(trajectory.is_usable());
  const double a = coin.W() / coin.M();
  const Scales scales = model.scales(std::array{v0, x0});
  for (Eigen::Index row = 0; row < 3; ++row) {
    const double t = trajectory.times[row];
    CHECK_THAT(trajectory.states(row, 0),
               WithinAbs(v0 + a * t, promised(trajectory, 1e-10, scales.velocity)));
    CHECK_THAT(trajectory.states(row, 1),
               WithinAbs(x0 + v0 * t + a * t * t / 2.0,
                         promised(trajectory, 1e-10, scales.length + scales.velocity * t)));
  }
}

TEST_CASE("a rising body mirrors a falling one of opposite density contrast and equal total inertia") {
  // M v' = W - D |v| v is odd in (v, W). Reversing density - fluid_density reverses W; the mass that the
  // lighter body lacks, 2 contrast area thickness, goes into its added mass, so that M is the same.
  const double contrast = 250.0;
  const double m_a = 2e-3;
  Coin heavy;
  heavy.fluid_density = 1000.0;
  heavy.density = heavy.fluid_density + contrast;
  Coin light = heavy;
  light.density = heavy.fluid_density - contrast;
  auto fixed_heavy = heavy.fixed();
  fixed_heavy["m_a"] = m_a;
  auto fixed_light = light.fixed();
  fixed_light["m_a"] = m_a + 2.0 * contrast * heavy.area * heavy.thickness;

  const ParametricModel falling(find_model("vertical_fall"), fixed_heavy, {"v(0)"});
  const ParametricModel rising(find_model("vertical_fall"), fixed_light, {"v(0)"});
  const std::vector<double> times = {0.05, 0.1, 0.2, 0.5, 1.0};
  for (const double v0 : {0.0, 0.05, -0.2}) {
    const Trajectory fall = integrate(falling, std::array{v0}, times);
    const Trajectory rise = integrate(rising, std::array{-v0}, times);
    REQUIRE(fall.is_usable());
    REQUIRE(rise.is_usable());
    CHECK(fall.states(4, 0) > 0.0);
    // Two integrations, each within what it promises; x adds up errors of v over one second.
    const Scales scales = falling.scales(std::array{v0});
    const double bound = 2.0 * promised(fall, 1e-10, scales.length + scales.velocity);
    CHECK((fall.states + rise.states).cwiseAbs().maxCoeff() < bound);
  }
}

TEST_CASE("the speed tends to the terminal speed, which is the scale of velocity") {
  const Coin coin;
  const ParametricModel model(find_model("vertical_fall"), coin.fixed(), {});
  // After 20 tau, tanh is 1 - 2 exp(-40): one, in doubles.
  const Trajectory trajectory = integrate(model, {}, std::array{20.0 * coin.tau()});
  CHECK_THAT(trajectory.states(0, 0),
             WithinAbs(coin.terminal(), promised(trajectory, 1e-10, coin.terminal())));
  const Scales scales = model.scales({});
  CHECK_THAT(scales.velocity, WithinRel(coin.terminal(), 1e-14));
  CHECK_THAT(scales.time, WithinRel(coin.tau(), 1e-14));
  CHECK_THAT(scales.length, WithinRel(coin.length(), 1e-14));
}

TEST_CASE("the scales are finite and positive without drag, contrast or gravity") {
  const Coin coin;
  const auto model = find_model("vertical_fall");
  for (const double C_D : {0.0, 1e-300, 1.0}) {
    for (const double density : {coin.fluid_density, coin.density, 1e-3}) {
      for (const double g : {0.0, 9.81}) {
        auto fixed = coin.fixed();
        fixed["C_D"] = C_D;
        fixed["density"] = density;
        fixed["g"] = g;
        const Scales scales = ParametricModel(model, fixed, {}).scales({});
        for (const double size : {scales.length, scales.time, scales.velocity}) {
          CHECK(std::isfinite(size));
          CHECK(size > 0.0);
        }
      }
    }
  }
}

TEST_CASE("a body as dense as the fluid stays where it is") {
  Coin coin;
  coin.density = coin.fluid_density;
  const ParametricModel model(find_model("vertical_fall"), coin.fixed(), {"x(0)"});
  const Trajectory trajectory = integrate(model, std::array{0.7}, std::array{1.0, 10.0});
  REQUIRE(trajectory.is_usable());
  CHECK(trajectory.states(1, 0) == 0.0);
  CHECK(trajectory.states(1, 1) == 0.7);
}

TEST_CASE("the derived added mass is that of a disc, 8/3 rho a^3, unless one is given") {
  const Coin coin;
  auto fixed = coin.fixed();
  const auto model = find_model("vertical_fall");
  const double radius = 0.01;
  fixed["area"] = std::numbers::pi * radius * radius;
  constexpr std::size_t kMa = 5;
  REQUIRE(model->info().parameters[kMa].name == "m_a");
  CHECK_THAT(ParametricModel(model, fixed, {}).parameters({})[kMa],
             WithinRel(8.0 / 3.0 * coin.fluid_density * radius * radius * radius, 1e-14));
  fixed["m_a"] = 0.0;
  CHECK(ParametricModel(model, fixed, {}).parameters({})[kMa] == 0.0);
}

TEST_CASE("the derived added mass follows the area, and so do the derivatives") {
  const Coin coin;
  auto fixed = coin.fixed();
  fixed.erase("area");
  const std::array state = {0.3, 0.0};
  const auto model = find_model("vertical_fall");

  // f = (w A - d A |v| v) / (mu A + M_a(A)) with M_a ~ A^(3/2), or M_a given. Both numerator and mu A are
  // linear in A, so df/dA = f/A - f (mu + M_a')/M = f (M_a/A - M_a')/M, with M_a' = 3/2 M_a/A if derived and
  // 0 if given.
  for (const bool given : {false, true}) {
    auto all = fixed;
    if (given) all["m_a"] = coin.m_a();
    const ParametricModel parametric(model, all, {"area"});
    ParametricModel::Workspace workspace = parametric.make_workspace();
    RhsDerivatives derivatives;
    std::array<double, 2> f;
    parametric.rhs_with_derivatives(0.0, state, std::array{coin.area}, f, derivatives, workspace);
    const double expected = f[0] * (given ? 1.0 : -0.5) * coin.m_a() / coin.area / coin.M();
    CHECK_THAT(derivatives.df_dq(0, 0), WithinRel(expected, 1e-12));

    // By central differences over h = 1e-5 of the area: truncation h^2 ~ 1e-10 and round-off eps/h ~ 1e-11 of
    // f/area.
    const double h = 1e-5 * coin.area;
    std::array<double, 2> above, below;
    parametric.rhs(0.0, state, std::array{coin.area + h}, above, workspace);
    parametric.rhs(0.0, state, std::array{coin.area - h}, below, workspace);
    CHECK_THAT((above[0] - below[0]) / (2.0 * h), WithinAbs(expected, 1e-8 * std::abs(f[0]) / coin.area));
  }
}
