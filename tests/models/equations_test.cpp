#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "../error_text.h"
#include "samara/base/errors.h"
#include "samara/models/checks/check_model.h"
#include "samara/models/checks/parameter_warnings.h"
#include "samara/models/equations/equation_model.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/integrators/rk4.h"
#include "samara/models/laws/law_model.h"
#include "samara/models/trajectories/check_family.h"
#include "samara/models/trajectories/reference_trajectories.h"
#include "samara/models/trajectories/step_trajectories.h"

using namespace samara::models;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

ParameterInfo positive_number(const std::string& name, const std::string& unit) {
  return {.name = name, .unit = unit, .description = "of the test", .lower = 0.0};
}

/// x' = expression of x, y in no unit, and p.
Equations one_rate(const std::string& text) {
  return {.title = "of a test",
          .states = {{.name = "x", .unit = "1", .description = "a state"},
                     {.name = "y", .unit = "1", .description = "a state"}},
          .parameters = {positive_number("p", "1")},
          .rates = {text, "0"}};
}

double rate(const Model& model, double t, std::vector<double> x, std::vector<double> p) {
  std::vector<double> f(x.size());
  const std::vector<char> given(p.size(), 1);
  model.rhs(t, x, {std::move(p), given}, f);
  return f[0];
}

/// A mass on a spring in metres and kilograms.
Equations spring() {
  return {
      .name = "spring",
      .title = "A mass on a spring that stiffens, in a fluid",
      .states = {{.name = "x", .unit = "m", .description = "deflection"},
                 {.name = "v", .unit = "m/s", .description = "velocity"}},
      .parameters = {positive_number("mass", "kg"), positive_number("stiffness", "N/m"),
                     positive_number("drag", "kg/m"), positive_number("width", "m")},
      .abbreviations = {{"frequency", "sqrt(stiffness/mass)"}, {"speed", "sqrt(v^2 + (width*frequency)^2)"}},
      .rates = {"v", "-frequency^2*width*tanh(x/width) - drag/mass*speed*v"}};
}

/// The same, compiled.
struct CompiledSpring {
  static constexpr int kStates = 2, kParameters = 4;
  static ModelInfo info() {
    const Equations equations = spring();
    return {.name = "compiled_spring",
            .title = equations.title,
            .equations = "as the text has them",
            .frames = "along the spring",
            .source = "the test",
            .validity = "the test",
            .states = equations.states,
            .parameters = equations.parameters};
  }
  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    using std::sqrt;
    using std::tanh;
    const S frequency = sqrt(p[1] / p[0]);
    const S floor = p[3] * frequency;
    const S speed = sqrt(x[1] * x[1] + floor * floor);
    dxdt[0] = x[1];
    dxdt[1] = -frequency * frequency * p[3] * tanh(x[0] / p[3]) - p[2] / p[0] * speed * x[1];
  }
};

/// Laws have no way to compute what it lists.
struct SpringWithOutputs : CompiledSpring {
  static ModelInfo info() {
    ModelInfo info = CompiledSpring::info();
    info.outputs = {{.name = "energy", .unit = "J"}};
    return info;
  }
};

}  // namespace

TEST_CASE("an expression is worth what C++ makes of it") {
  using Function = std::function<double(double t, double x, double y, double p)>;
  const std::vector<std::pair<std::string, Function>> cases = {
      {"1 + 2*3 - 4/8", [](double, double, double, double) { return 6.5; }},
      {"-x^2", [](double, double x, double, double) { return -x * x; }},
      {"2^3^2 + 2**-1", [](double, double, double, double) { return 512.5; }},
      {"-(x - y) - -p", [](double, double x, double y, double p) { return -(x - y) + p; }},
      {"x/y/p*t", [](double t, double x, double y, double p) { return x / y / p * t; }},
      {"p^2.5 + p^y", [](double, double, double y, double p) { return std::pow(p, 2.5) + std::pow(p, y); }},
      {"x^-3", [](double, double x, double, double) { return 1.0 / (x * x * x); }},
      {"sin(x)*cos(y) + tan(x/4)",
       [](double, double x, double y, double) { return std::sin(x) * std::cos(y) + std::tan(x / 4); }},
      {"asin(x/4) + acos(y/4) + atan(x) + atan2(x, y)",
       [](double, double x, double y, double) {
         return std::asin(x / 4) + std::acos(y / 4) + std::atan(x) + std::atan2(x, y);
       }},
      {"exp(-x) + log(p) + sqrt(p) + sinh(x) + cosh(x) + tanh(x)",
       [](double, double x, double, double p) {
         return std::exp(-x) + std::log(p) + std::sqrt(p) + std::sinh(x) + std::cosh(x) + std::tanh(x);
       }},
      {"abs(x) + min(x, y) + 2*max(x, y) + sign(y) + step(x)",
       [](double, double x, double y, double) {
         return std::abs(x) + std::min(x, y) + 2 * std::max(x, y) + (y > 0 ? 1 : -1) + (x >= 0 ? 1 : 0);
       }},
      {"  pi*1.5e-1 + .5", [](double, double, double, double) { return std::numbers::pi * 0.15 + 0.5; }},
      {"3 [cm]/1 [mm] + 90 [deg]",
       [](double, double, double, double) { return 30.0 + std::numbers::pi / 2; }},
  };
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-2.0, 2.0);
  for (const auto& [text, expected] : cases) {
    const auto model = equation_model(one_rate(text));
    CAPTURE(text);
    for (int k = 0; k < 20; ++k) {
      const double t = std::abs(number(random)), x = number(random), y = number(random),
                   p = std::abs(number(random));
      CHECK_THAT(rate(*model, t, {x, y}, {p}), WithinRel(expected(t, x, y, p), 1e-13));
    }
  }
}

TEST_CASE("equations as text pass the checks of models: derivatives, units, groups of points") {
  const auto model = equation_model(spring());
  for (const std::string& finding : check_model(*model).findings) FAIL_CHECK(finding);
  for (const char* text :
       {"p*sin(x)*exp(-y^2) + x/(1 + y^2)", "p^x*cosh(y) + atan2(x, 2 + y^2)", "tanh(x*y)/p - log(p + x^2)",
        "sqrt(p + x^2)*atan(y) + asin(x/4)*acos(y/4)", "x^5*y^-4*p^2.5", "tan(x/4) + sinh(y) + p*t*x"}) {
    CAPTURE(text);
    for (const std::string& finding : check_model(*equation_model(one_rate(text))).findings)
      FAIL_CHECK(finding);
  }
}

TEST_CASE("text and C++ make the same model") {
  const auto text = equation_model(spring());
  const auto compiled = make_model<CompiledSpring>();
  for (const std::string& finding : check_model(*compiled).findings) FAIL_CHECK(finding);
  std::mt19937 random(12);
  std::uniform_real_distribution<double> number(0.1, 2.0);
  constexpr int kPoints = 100;  // more than go together, and not a multiple of these
  Eigen::VectorXd t(kPoints);
  Eigen::MatrixXd x(2, kPoints), p(4, kPoints);
  for (double& value : t) value = number(random);
  for (double& value : x.reshaped()) value = number(random) - 1.0;
  for (double& value : p.reshaped()) value = number(random);
  Eigen::MatrixXd rates(2, kPoints), expected(2, kPoints), jacobians(4, kPoints),
      expected_jacobians(4, kPoints);
  text->rhs_at_points(t, x, p, rates);
  compiled->rhs_at_points(t, x, p, expected);
  CHECK((rates - expected).cwiseAbs().maxCoeff() < 1e-13 * expected.cwiseAbs().maxCoeff());
  text->jacobians_at_points(t, x, p, jacobians);
  compiled->jacobians_at_points(t, x, p, expected_jacobians);
  CHECK((jacobians - expected_jacobians).cwiseAbs().maxCoeff() <
        1e-13 * expected_jacobians.cwiseAbs().maxCoeff());
}

TEST_CASE("a law that lists outputs is refused") {
  CHECK_THAT(error_text<samara::ArgumentError>([] { const LawModel<SpringWithOutputs, false> refused; }),
             Contains("law \"compiled_spring\" lists outputs, expected none"));
}

TEST_CASE("equations tell by themselves where they are affine and what they do not depend on") {
  Equations fall{.states = {{.name = "z", .unit = "m"}, {.name = "v", .unit = "m/s"}},
                 .parameters = {positive_number("g", "m/s^2"), positive_number("drag", "1/m"),
                                positive_number("size", "m"), positive_number("share", "1")},
                 .rates = {"v", "g*share - drag*size*v^2/(1 [m] + size)"}};
  const auto model = equation_model(fall);
  const ModelInfo& info = model->info();
  CHECK(info.affine_in == std::vector<std::string>{"g", "drag"});
  CHECK(info.symmetries == std::vector<std::string>{"translation of z"});
  CHECK_THAT(info.equations, Contains("v' = g*share"));
}

TEST_CASE("rates depend on what stands in a step, and are not affine in what stands at a kink") {
  const auto braked =
      equation_model({.states = {{.name = "x", .unit = "1"}, {.name = "v", .unit = "1"}},
                      .parameters = {positive_number("brake", "1"), positive_number("edge", "1")},
                      .rates = {"v", "-brake*step(x - edge)"}});
  CHECK(braked->info().symmetries.empty());
  CHECK(braked->info().affine_in == std::vector<std::string>{"brake"});
  CHECK(equation_model(one_rate("abs(p)*x"))->info().affine_in.empty());
}

TEST_CASE("roots, powers and atan2 have finite derivatives where what they are taken of rests") {
  const auto by_states_at_rest = [](const Model& model) {
    const std::size_t parameters = model.info().parameters.size();
    std::vector<double> f(2);
    Eigen::MatrixXd by_x(2, 2), by_p(2, static_cast<Eigen::Index>(parameters));
    const ParameterValues p = {std::vector<double>(parameters, 1.5), std::vector<char>(parameters, 1)};
    model.rhs_with_derivatives(0.0, std::vector<double>(2), p, f, by_x, by_p);
    CHECK(by_p.allFinite());
    return by_x;
  };
  for (const char* text : {"-x^p", "sqrt(x^2 + y^2)", "(x^2 + y^2)^0.3", "atan2(x, y)"}) {
    CAPTURE(text);
    CHECK(by_states_at_rest(*equation_model(one_rate(text))).isZero(0.0));
  }
  CHECK(std::isinf(by_states_at_rest(*equation_model(one_rate("sqrt(x)")))(0, 0)));
}

TEST_CASE("a fall from rest against a quadratic drag has the sensitivities of its solution") {
  const double drag = 0.7, g = 9.81;
  const auto fall =
      equation_model({.states = {{.name = "u", .unit = "m/s"}, {.name = "v", .unit = "m/s"}},
                      .parameters = {positive_number("drag", "1/m"), positive_number("g", "m/s^2")},
                      .rates = {"-drag*sqrt(u^2 + v^2)*u", "-g - drag*sqrt(u^2 + v^2)*v"}});
  Eigen::MatrixXd jacobians(4, 3);
  const Eigen::MatrixXd x = Eigen::MatrixXd::Zero(2, 3), p = Eigen::Vector2d(drag, g).replicate(1, 3);
  fall->jacobians_at_points(Eigen::VectorXd::Zero(3), x, p, jacobians);
  CHECK(jacobians.isZero(0.0));
  const ParametricModel model(fall, {{"g", g}}, {"drag"});
  const std::vector<double> q = {drag}, times = {0.2, 1.0};
  const Trajectory found = integrate(model, q, times, {}, true);
  REQUIRE(found.is_usable());
  for (Eigen::Index row = 0; row < 2; ++row) {
    // v = -w tanh(s) with s = g t/w, where w = sqrt(g/drag).
    const double w = std::sqrt(g / drag), s = g * found.times[row] / w;
    const double by_drag = w / (2.0 * drag) * (std::tanh(s) - s / (std::cosh(s) * std::cosh(s)));
    CHECK(found.sensitivities[0](row, 1) == Approx(by_drag).epsilon(1e-6));
    CHECK(found.sensitivities[0](row, 0) == 0.0);
  }
}

TEST_CASE("what is no expression is refused with its column and what was expected") {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "at column 1: the expression ends"},
      {"x +", "at column 4: the expression ends"},
      {"x $ y", "at column 3: \"$ y\" is left over"},
      {"(x", "at column 3: the expression ends, expected \")\""},
      {"2x", "at column 2: \"x\" follows a number at once"},
      {"1.2.3", "follows a number at once"},
      {"1e999", "too large or too small"},
      {"q*x", "there is no \"q\""},
      {"sine(x)", "did you mean \"sin\"?"},
      {"sin", "without its argument in parentheses"},
      {"x(2)", "\"x\" is no function; a product is written with *"},
      {"atan2(x)", "\",\" was expected"},
      {"x/0", "divides by zero"},
      {"x + sqrt(-1)", "at column 5: the result is"},
      {"log(0)*x", "at column 1: the result is -inf, expected a finite number"},
      {"x*10^1000", "the result is inf"},
      {"ln(x)", "\"log\" is the natural logarithm"},
      {"3 [furlong]", "furlong"},
      {"3 [m", "no \"]\" follows"},
      {std::string(500, '('), "more than 200 deep"},
      {std::string(500, '-') + "x", "more than 200 deep"},
      {"\x1b[2J", "\\x1b"},
  };
  for (const auto& [text, expected] : cases) {
    CAPTURE(text);
    CHECK_THAT(error_text<EquationError>([&] { equation_model(one_rate(text)); }), Contains(expected));
  }
  std::string longest = "x";
  while (longest.size() < 18'000) longest += " + sin(x*y)*x";
  CHECK_NOTHROW(equation_model(one_rate(longest)));
  CHECK_THAT(error_text<EquationError>([&] { equation_model(one_rate(longest + longest)); }),
             Contains("at most 20000"));
}

TEST_CASE("units that do not fit are refused") {
  const auto with = [](const std::string& rate_of_x, const std::string& rate_of_v) {
    Equations equations = spring();
    equations.rates = {rate_of_x, rate_of_v};
    return error_text<EquationError>([&] { equation_model(equations); });
  };
  CHECK_THAT(with("x", "0"), Contains("the rate of \"x\" is in m, expected m s^-1"));
  CHECK_THAT(with("v", "v + x"), Contains("sum of something in m s^-1 and something in m"));
  CHECK_THAT(with("v", "sin(x)"), Contains("sin is taken of something in m, expected a plain number"));
  CHECK_THAT(with("v", "v^x"), Contains("the exponent is in m"));
  CHECK_THAT(with("v", "2^mass"), Contains("the exponent is in kg"));
  CHECK_THAT(with("v", "v^pi"), Contains("a whole number or a simple fraction"));
  CHECK_THAT(with("max(v, x)", "0"), Contains("max of something in m s^-1 and something in m"));
  CHECK_THAT(with("atan2(v, x)", "0"), Contains("atan2 of"));
  Equations squared = spring();
  squared.abbreviations = {{"s0", "x*x"}};
  for (int k = 1; k < 33; ++k)
    squared.abbreviations.push_back({fmt::format("s{}", k), fmt::format("s{0}*s{0}", k - 1)});
  CHECK_THAT(error_text<EquationError>([&] { equation_model(squared); }),
             Contains("a product is measured in m^1024, expected powers of at most 1000"));
  CHECK(with("max(0, v)", "sqrt(v^2*v^2)/width") == "no exception");
  CHECK(with("x*sqrt(stiffness/mass)", "x^(3/2)/sqrt(x)*stiffness/mass") == "no exception");
}

TEST_CASE("names, numbers and counts that make no model are refused") {
  const auto changed = [](const std::function<void(Equations&)>& change) {
    Equations equations = spring();
    change(equations);
    return error_text<EquationError>([&] { equation_model(equations); });
  };
  CHECK_THAT(changed([](Equations& e) { e.states.clear(); }), Contains("no state"));
  CHECK_THAT(changed([](Equations& e) { e.rates.pop_back(); }), Contains("1 rates for 2 states"));
  CHECK_THAT(changed([](Equations& e) {
               e.abbreviations = {{"a", "2*b"}, {"b", "x"}};
             }),
             Contains("\"b\" is not known here yet"));
  CHECK_THAT(changed([](Equations& e) { e.states[0].name = "t"; }), Contains("\"t\" is the time"));
  CHECK_THAT(changed([](Equations& e) { e.states[0].name = "v"; }), Contains("\"v\" is given twice"));
  CHECK_THAT(changed([](Equations& e) { e.parameters[0].name = "sin"; }), Contains("\"sin\" is no name"));
  CHECK_THAT(changed([](Equations& e) { e.parameters[0].name = "2m"; }), Contains("\"2m\" is no name"));
  CHECK_THAT(changed([](Equations& e) { e.parameters[0].unit = "g"; }),
             Contains("\"g\", expected one of the SI"));
  CHECK_THAT(changed([](Equations& e) { e.parameters[0].unit = "kilo"; }), Contains("kilo"));
  CHECK_THAT(changed([](Equations& e) { e.parameters[0].default_value = -1.0; }),
             Contains("expected > 0 kg"));
  CHECK_THAT(changed([](Equations& e) { e.states[0].default_initial = std::nan(""); }), Contains("finite"));
  CHECK_THAT(changed([](Equations& e) { e.states[0].scale = 0.0; }), Contains("positive"));
  CHECK_THAT(changed([](Equations& e) { e.abbreviations[0].first = "x"; }), Contains("\"x\" is given twice"));
}

namespace {

/// A pendulum that hangs from a rail which moves, and where its tip is.
Equations pendulum() {
  return {
      .name = "pendulum_of_a_test",
      .states = {{.name = "angle", .unit = "rad", .default_initial = 0.5},
                 {.name = "spin", .unit = "rad/s", .default_initial = 0.0}},
      .parameters = {positive_number("length", "m"), positive_number("gravity", "m/s^2"),
                     positive_number("rail", "m/s")},
      .abbreviations = {{"aside", "length*sin(angle)"}},
      .rates = {"spin", "-gravity/length*sin(angle)"},
      .outputs = {{{.name = "tip", .unit = "m"}, "aside + rail*t"},
                  {{.name = "energy", .unit = "m^2/s^2"}, "length^2*spin^2/2 - gravity*length*cos(angle)"}}};
}

}  // namespace

TEST_CASE(
    "outputs that equations derive from their states come with trajectories, and with their derivatives") {
  const auto model = equation_model(pendulum());
  for (const std::string& finding : check_model(*model).findings) FAIL_CHECK(finding);
  const std::map<std::string, double> fixed = {{"gravity", 9.81}, {"rail", 0.3}};
  const std::map<std::string, Interval> box = {{"length", {0.5, 1.5}}, {"angle(0)", {0.2, 1.2}}};
  const auto integrated = reference_trajectories(model, fixed, box);
  const auto stepped = step_trajectories(model, fixed, box, 1e-3);
  for (const TrajectoryFamily* family : {integrated.get(), stepped.get()}) {
    CheckFamilyOptions options;
    options.times = {0.0, 0.4, 1.1};
    const samara::Check check = check_family(*family, options);
    for (const std::string& finding : check.findings) FAIL_CHECK(finding);
    const std::vector<double> q = {0.7, 0.8};  // angle(0), length
    const FamilyTrajectory one = trajectory(*family, q, {0.0, 0.9}, {"tip", "energy", "angle"});
    CHECK(one.values(0, 0) == Approx(0.8 * std::sin(0.7)));
    CHECK(one.values(1, 0) == Approx(0.8 * std::sin(one.values(1, 2)) + 0.3 * 0.9));
    CHECK(one.values(1, 1) == Approx(-9.81 * 0.8 * std::cos(0.7)).epsilon(1e-8));  // what it began with
  }
}

TEST_CASE(
    "trajectories whose outputs use the time are no parts of each other, even where the equations do not") {
  const std::map<std::string, double> fixed = {{"gravity", 9.81}, {"rail", 0.3}};
  const std::map<std::string, Interval> box = {{"length", {0.5, 1.5}}};
  CHECK_FALSE(reference_trajectories(equation_model(pendulum()), fixed, box)->info().autonomous);
  Equations steady = pendulum();
  steady.outputs.erase(steady.outputs.begin());  // the tip, which moves along the rail
  CHECK(reference_trajectories(equation_model(steady), fixed, box)->info().autonomous);
  // Its derivative by the time is zero wherever there is one.
  steady.outputs[0].second += "*(1 + 0.5*step(t - 2 [s]))";
  CHECK_FALSE(reference_trajectories(equation_model(steady), fixed, box)->info().autonomous);
}

TEST_CASE("outputs that make no sense are refused") {
  const auto refused = [](const std::string& name, const std::string& unit, const std::string& text) {
    Equations equations = pendulum();
    equations.outputs = {{{.name = name, .unit = unit}, text}};
    return error_text<EquationError>([&] { equation_model(equations); });
  };
  CHECK_THAT(refused("tip", "m/s", "aside"), Contains("\"tip\" is in m, expected m s^-1"));
  CHECK_THAT(refused("angle", "1", "angle"), Contains("given twice"));
  CHECK_THAT(refused("tip", "cm", "aside"), Contains("without a factor"));
  CHECK_THAT(refused("tip", "m", "asid"), Contains("did you mean \"aside\""));
  CHECK_THAT(refused("t", "s", "t"), Contains("is the time"));
}

TEST_CASE("a damaged expression is refused, or still keeps its units") {
  std::mt19937 random(13);
  const std::string letters = "xvpt0123456789.+-*/^()[], amswidthfrequencystiffness";
  int refused = 0, taken = 0;
  constexpr int kDamaged = 100'000;
  for (int k = 0; k < kDamaged; ++k) {
    Equations equations = spring();
    std::string& text = equations.rates[1];
    for (int change = 0; change < 1 + k % 2; ++change) {
      const std::size_t at = random() % (text.size() + 1);
      const char letter = letters[random() % letters.size()];
      const std::size_t kind = random() % 3;
      if (kind == 0) text.insert(at, 1, letter);
      if (kind == 1 && at < text.size()) text.erase(at, 1);
      if (kind == 2 && at < text.size()) text[at] = letter;
    }
    std::shared_ptr<const Model> model;
    try {
      model = equation_model(equations);
    } catch (const samara::ArgumentError&) {
      ++refused;
      continue;
    }
    ++taken;
    // Lengths, masses and times in other units: the rate must follow.
    const double length = 3.0, mass = 7.0, time = 2.0;
    const std::vector<double> x = {0.3, 0.4}, p = {1.1, 2.3, 0.7, 0.9};
    const std::vector<double> scaled_x = {x[0] * length, x[1] * length / time};
    const std::vector<double> scaled_p = {p[0] * mass, p[1] * mass / (time * time), p[2] * mass / length,
                                          p[3] * length};
    std::vector<double> f(2), scaled_f(2);
    const std::vector<char> given(4, 1);
    model->rhs(0.5, x, {p, given}, f);
    model->rhs(0.5 * time, scaled_x, {scaled_p, given}, scaled_f);
    const double expected = f[1] * length / (time * time);
    // A text with a unit of its own holds numbers that do not follow.
    if (!std::isfinite(f[1]) || text.find('[') != std::string::npos) continue;
    CAPTURE(text);
    CHECK_THAT(scaled_f[1], WithinRel(expected, 1e-9) || Catch::Matchers::WithinAbs(expected, 1e-9));
  }
  CHECK(refused > kDamaged / 6);
  CHECK(taken > kDamaged / 50);
}

TEST_CASE("a force that acts for a hundredth of the time is not leapt over") {
  const auto pushed = equation_model({.name = "pushed",
                                      .states = {{.name = "x", .unit = "1"}},
                                      .parameters = {{.name = "a", .unit = "1"}},
                                      .rates = {"a*exp(-((t - 5.3)/0.05)^2)/(0.05*sqrt(pi))"}});
  const ParametricModel model(pushed, {{"x(0)", 0.0}}, {"a"});
  const std::vector<double> q = {1.5}, times = {0.0, 4.0, 6.0, 10.0};
  for (const bool stiff : {false, true}) {
    const Trajectory found = integrate(model, q, times, {.stiff = stiff});
    REQUIRE(found.is_usable());
    CHECK(std::abs(found.states(1, 0)) < 1e-8);
    CHECK(found.states(2, 0) == Approx(1.5).epsilon(1e-7));
    CHECK(found.states(3, 0) == Approx(1.5).epsilon(1e-7));
  }
}

TEST_CASE("what acts for a while is met, also where it has nothing to act on at the start, or is small") {
  for (const char* text :
       {"push*cos(t/2000) - exp(-((t - 47.2)/0.5)^2)*v", "push*(t/100 + 0.09*exp(-(t - 47.2)^2))"}) {
    const auto pushed = equation_model({.states = {{.name = "v", .unit = "1"}},
                                        .parameters = {{.name = "push", .unit = "1"}},
                                        .rates = {text}});
    CAPTURE(text);
    const ParametricModel model(pushed, {}, {"push"});
    const std::vector<double> q = {1.0}, times = {100.0};
    const Trajectory found = integrate(model, q, times);
    REQUIRE(found.is_usable());
    const double stepped = integrate_rk4(model, q, times, {.step = 0.01}).states(0, 0);
    CHECK(found.states(0, 0) == Approx(stepped).epsilon(1e-7));
  }
}

TEST_CASE("plain numbers that are called as sizes of bodies are no sizes") {
  const auto neuron = equation_model(
      {.name = "neuron",
       .states = {{.name = "v", .unit = "1"}, {.name = "w", .unit = "1"}},
       .parameters = {{.name = "a", .unit = "1"}, {.name = "b", .unit = "1"}, {.name = "c", .unit = "1"}},
       .rates = {"c*(v - v^3/3 + w)", "-(v - a + b*w)/c"}});
  CHECK(parameter_warnings(*neuron, {{"a", 0.2}, {"b", 0.2}, {"c", 3.0}}).empty());
}
