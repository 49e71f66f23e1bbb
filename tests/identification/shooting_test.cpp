/// Fits of captures that are cut into segments.
#include <catch2/catch.hpp>

#include "files.h"
#include "plate_captures.h"
#include "residual_derivatives.h"
#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/composition/mixed_trajectories.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/smoothing/continuous_angles.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "samara/pgd/tensors/random.h"

using namespace samara::identification;
using Catch::Contains;
using samara::models::find_model;

namespace {

constexpr int kFrames = 60;
constexpr double kNoise = 0.02;  ///< of the unit of length, half a chord

std::map<std::string, double> plate(double inertia_ratio) {
  return {{"inertia_ratio", inertia_ratio}, {"beta", 1.0 / 14.0}, {"B", 1.0}};
}

const std::map<std::string, double>& truth() {
  static const std::map<std::string, double> values = {
      {"C_T", 1.2}, {"C_R", 3.14159}, {"A", 1.4}, {"mu1", 0.2}};
  return values;
}

/// A tumbling plate in its developed motion, by CVODES.
Capture tumbling(double noise, std::uint64_t seed) {
  std::map<std::string, double> values = plate(1.4);
  values.insert(truth().begin(), truth().end());
  const std::vector<double> times = plate_times(kFrames, 20.0);
  return seen_plate(times, plate_states(values, times), noise, seed);
}

std::map<std::string, samara::models::Interval> plate_box() {
  std::map<std::string, samara::models::Interval> box;
  for (const auto& [name, value] : truth()) box[name] = {0.3 * value, 3.0 * value};
  for (const char* name : {"vx(0)", "vy(0)", "w(0)"}) box[name] = {-8.0, 8.0};
  box["theta(0)"] = {-60.0, 60.0};
  return box;
}

FitOptions plate_options() {
  FitOptions options;
  options.loss = {.kind = LossKind::none, .scales = {{"x", kNoise}, {"y", kNoise}, {"theta", kNoise}}};
  options.segments.length = 1.0;
  options.starts.count = 1;
  return options;
}

std::unique_ptr<samara::models::TrajectoryFamily> tumbling_plates() {
  return step_trajectories(find_model("falling_plate_nd"), plate(1.4), plate_box(), 0.01);
}

/// A body whose attitude and place are seen, and everything else is not.
std::unique_ptr<samara::models::TrajectoryFamily> card_family() {
  std::map<std::string, samara::models::Interval> box = {{"C_R", {0.3, 3.0}}};
  for (const char* name : {"x(0)", "y(0)", "z(0)"}) box[name] = {-50.0, 50.0};
  for (const char* name : {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}) box[name] = {-1.1, 1.1};
  for (const char* name : {"ux(0)", "uy(0)", "uz(0)"}) box[name] = {-20.0, 20.0};
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"}) box[name] = {-300.0, 300.0};
  return step_trajectories(find_model("immersed_body"),
                           {{"a", 0.035},
                            {"b", 0.02},
                            {"c", 1e-4},
                            {"density", 1200.0},
                            {"C_D0", 0.05},
                            {"C_D90", 0.31},
                            {"C_T", 0.91},
                            {"C_w", 2.0}},
                           box, 1e-3);
}

Capture card_capture() {
  Capture capture;
  capture.id = "card";
  capture.times = Eigen::VectorXd::LinSpaced(13, 0.0, 0.05);
  const Eigen::VectorXd& t = capture.times;
  const Eigen::ArrayXd angle = 3.0 * t.array();
  capture.channels = {{"x", "m", 0.3 * t},
                      {"y", "m", 0.0 * t},
                      {"z", "m", -0.8 * t},
                      {"qw", "1", (0.5 * angle).cos()},
                      {"qx", "1", (0.5 * angle).sin()},
                      {"qy", "1", 0.0 * t},
                      {"qz", "1", 0.0 * t}};
  return capture;
}

}  // namespace

TEST_CASE("a tumbling plate gives its coefficients back from a start 30 percent away") {
  FitOptions options = plate_options();
  options.starts.initial = {{"C_T", 0.84}, {"C_R", 4.1}, {"A", 1.82}, {"mu1", 0.14}};
  const FitResult result = fit(*tumbling_plates(), std::vector{tumbling(kNoise, 7)}, options);
  INFO(result.message);
  CHECK(result.status == samara::Termination::converged);
  CHECK(result.captures.at(0).segments == 6);
  CHECK(result.join_defect.value() < 0.01);
  for (const Coefficient& c : result.coefficients) {
    INFO(c.name << " = " << c.value << " +- " << c.naive_standard_error.value());
    // Normal errors: beyond four of them once in 16,000.
    CHECK(std::abs(c.value - truth().at(c.name)) < 4.0 * c.naive_standard_error.value());
  }
  // chi^2 of 180 values less 10 unknowns: 170 +- 18.
  CHECK(2.0 * result.cost > 170.0 - 4.0 * 18.5);
  CHECK(2.0 * result.cost < 170.0 + 4.0 * 18.5);
}

TEST_CASE("without noise the coefficients are exact to the error of the steps") {
  const FitResult result = fit(*tumbling_plates(), std::vector{tumbling(0.0, 1)}, plate_options());
  CHECK(result.status == samara::Termination::converged);
  // RK4 at h = 0.01 and the penalty of joins.
  for (const Coefficient& c : result.coefficients) CHECK(c.value == Approx(truth().at(c.name)).epsilon(1e-5));
}

TEST_CASE("where segments are cut does not matter to the answer") {
  const std::vector captures = {tumbling(kNoise, 3)};
  FitOptions options = plate_options();
  const FitResult six = fit(*tumbling_plates(), captures, options);
  options.segments.length = 0.6;
  const FitResult ten = fit(*tumbling_plates(), captures, options);
  REQUIRE(ten.captures.at(0).segments == 10);
  for (std::size_t k = 0; k < six.coefficients.size(); ++k) {
    const double error = six.coefficients[k].naive_standard_error.value();
    // What the penalty leaves of the joins.
    CHECK(std::abs(six.coefficients[k].value - ten.coefficients[k].value) < 0.01 * error);
    CHECK(ten.coefficients[k].naive_standard_error.value() == Approx(error).epsilon(0.02));
  }
}

TEST_CASE("what is said of a single number of an attitude is refused, since its turn is compared") {
  const auto family = card_family();
  const std::vector captures{card_capture()};
  FitOptions scaled, averaged;
  scaled.loss.scales["qy"] = 0.01;
  averaged.compared.periods["qw"] = 1.0;
  CHECK_THAT(error_of<samara::ArgumentError>([&] { make_problem(family->info(), captures, scaled); }),
             Contains("loss.scale: \"qy\" is a number of an attitude (qw, qx, qy, qz)") &&
                 Contains("attitude_scale is its size"));
  CHECK_THAT(error_of<samara::ArgumentError>([&] { make_problem(family->info(), captures, averaged); }),
             Contains("periods: \"qw\" is a number of an attitude"));
}

TEST_CASE("residuals and joins have the derivatives of differences, attitudes too") {
  const auto family = card_family();
  FitOptions options;
  options.segments.length = 0.025;
  options.loss.length_scale = 0.01;
  const FitProblem problem = make_problem(family->info(), std::vector{card_capture()}, options);
  REQUIRE(problem.segments.size() == 2);
  REQUIRE(problem.attitude_scale);
  SegmentResidual residual(*family, problem, problem.segments[0]);
  samara::pgd::Random random(5);
  residual.set_join_weights(Eigen::VectorXd::LinSpaced(problem.join_rows(), 1.0, 2.0));
  Eigen::VectorXd shared = Eigen::VectorXd::Constant(1, 1.3);
  const auto random_own = [&] {
    Eigen::VectorXd own(13);
    for (double& value : own) value = random.normal();
    return own;
  };
  Eigen::VectorXd own = random_own(), next = random_own();
  check_derivatives(residual, shared, own, next);
  CHECK(residual.by_next().bottomRows(problem.join_rows()).cwiseAbs().maxCoeff() > 0.5);
}

TEST_CASE("an angle that was measured on the circle fits as one that was unwrapped") {
  const Capture unwrapped = tumbling(kNoise, 11);
  Capture wrapped = unwrapped;
  for (double& theta : wrapped.channels[0].values) theta = std::remainder(theta, 2.0 * M_PI);
  FitOptions options = plate_options();
  options.compared.periods = {{"theta", 2.0 * M_PI}};
  const FitResult a = fit(*tumbling_plates(), std::vector{unwrapped}, plate_options());
  const FitResult b = fit(*tumbling_plates(), std::vector{wrapped}, options);
  for (std::size_t k = 0; k < a.coefficients.size(); ++k) {
    CHECK(b.coefficients[k].value ==
          Approx(a.coefficients[k].value).margin(1e-3 * a.coefficients[k].naive_standard_error.value()));
  }
}

TEST_CASE("coefficients that move by factors end where those end that move by differences") {
  const std::vector captures = {tumbling(kNoise, 13)};
  FitOptions options = plate_options();
  const FitResult linear = fit(*tumbling_plates(), captures, options);
  options.unknowns.log_scale = {"C_T", "mu1"};
  const FitResult logarithmic = fit(*tumbling_plates(), captures, options);
  for (std::size_t k = 0; k < linear.coefficients.size(); ++k) {
    const double error = linear.coefficients[k].naive_standard_error.value();
    CHECK(logarithmic.coefficients[k].value == Approx(linear.coefficients[k].value).margin(1e-3 * error));
    CHECK(logarithmic.coefficients[k].naive_standard_error.value() == Approx(error).epsilon(1e-2));
  }
}

TEST_CASE("a strong prior decides, a weak one leaves the data alone") {
  const std::vector captures = {tumbling(kNoise, 17)};
  FitOptions options = plate_options();
  const FitResult alone = fit(*tumbling_plates(), captures, options);
  const auto coefficient = [](const FitResult& result, const std::string& name) {
    return *std::ranges::find(result.coefficients, name, &Coefficient::name);
  };
  options.priors.coordinates = {{"C_T", {.mean = 2.0, .deviation = 100.0}}};
  CHECK(coefficient(fit(*tumbling_plates(), captures, options), "C_T").value ==
        Approx(coefficient(alone, "C_T").value).epsilon(1e-4));
  options.priors.coordinates = {{"C_T", {.mean = 1.5, .deviation = 1e-6, .logarithmic = true}}};
  const Coefficient held = coefficient(fit(*tumbling_plates(), captures, options), "C_T");
  CHECK(held.value == Approx(1.5).epsilon(1e-4));
  CHECK(held.naive_standard_error.value() < 1e-4);
}

TEST_CASE("what is known of a capture is taken from its label") {
  // Two plates of different inertia, each with its own in a label.
  std::vector<Capture> captures;
  for (const double inertia : {1.4, 1.4}) {
    Capture capture = tumbling(kNoise, captures.size() + 1);
    capture.id = std::to_string(captures.size());
    capture.labels["inertia"] = std::to_string(inertia);
    captures.push_back(std::move(capture));
  }
  std::map<std::string, samara::models::Interval> box = plate_box();
  box["inertia_ratio"] = {1.0, 2.0};
  const auto family =
      step_trajectories(find_model("falling_plate_nd"), {{"beta", 1.0 / 14.0}, {"B", 1.0}}, box, 0.01);
  FitOptions options = plate_options();
  options.unknowns.known = {{"inertia_ratio", "inertia"}};
  const FitResult known = fit(*family, captures, options);
  const FitResult held = fit(*tumbling_plates(), captures, plate_options());
  REQUIRE(known.coefficients.size() == 4);
  for (std::size_t k = 0; k < 4; ++k)
    CHECK(known.coefficients[k].value == Approx(held.coefficients[k].value).epsilon(1e-6));

  // As a power of a label, and as the first value of a channel where there is no label.
  captures[0].labels["inertia"] = std::to_string(std::sqrt(1.4 / 2.0));
  captures[1].labels.clear();
  captures[1].channels.push_back(
      {"inertia", "1", Eigen::VectorXd::Constant(captures[1].frame_count(), std::sqrt(1.4 / 2.0))});
  FitOptions of_power = options;
  of_power.unknowns.known = {{"inertia_ratio", {"inertia", 2.0, 2.0}}};
  of_power.compared.outputs = {"x", "y", "theta"};
  const FitResult powers = fit(*family, captures, of_power);
  CHECK_THAT(powers.captures[1].known.at("inertia_ratio"), Catch::Matchers::WithinRel(1.4, 1e-12));
  for (std::size_t k = 0; k < 4; ++k)
    CHECK(powers.coefficients[k].value == Approx(held.coefficients[k].value).epsilon(1e-5));
  captures[1].channels.pop_back();
  for (Capture& capture : captures) capture.labels["inertia"] = "1.4";

  captures[1].labels["inertia"] = "heavy";
  CHECK_THROWS_WITH(fit(*family, captures, options), Catch::Contains("the label \"inertia\" is \"heavy\"") &&
                                                         Catch::Contains("finite number"));
  captures[1].labels.clear();
  CHECK_THROWS_WITH(fit(*family, captures, options), Catch::Contains("no label \"inertia\""));
}

TEST_CASE("segments are refused where a state cannot start anew") {
  std::map<std::string, samara::models::Interval> box = plate_box();
  box.erase("w(0)");
  const auto family = step_trajectories(find_model("falling_plate_nd"), plate(1.4), box, 0.01);
  CHECK_THROWS_WITH(fit(*family, std::vector{tumbling(kNoise, 1)}, plate_options()),
                    Catch::Contains("\"w(0)\" is not a free coordinate of each capture"));
}

TEST_CASE("a capture that the model cannot follow is said not to join") {
  // Half of the capture is of another body.
  Capture capture = tumbling(kNoise, 1);
  for (Channel& channel : capture.channels) channel.values.tail(30) *= 0.3;
  const FitResult result = fit(*tumbling_plates(), std::vector{capture}, plate_options());
  const bool told = result.status != samara::Termination::converged ||
                    result.warnings.has(WarningKind::model, "misses") ||
                    result.warnings.has(WarningKind::segments, "do not join");
  CHECK(told);
}

TEST_CASE("a search of the box finds the valley from a corner, the same one every time") {
  const std::vector captures = {tumbling(kNoise, 19)};
  FitOptions options = plate_options();
  options.starts.initial = {{"C_T", 3.5}, {"C_R", 1.0}, {"A", 4.0}, {"mu1", 0.07}};
  for (const GlobalMethod method : {GlobalMethod::controlled_random, GlobalMethod::direct}) {
    options.starts.global = {.method = method, .budget = 120, .seed = 3};
    const FitResult result = fit(*tumbling_plates(), captures, options);
    INFO(to_string(method));
    REQUIRE(result.global_search);
    CHECK(result.global_search->method == to_string(method));
    CHECK(result.global_search->evaluations <= 120);
    CHECK(result.global_search->evaluations > 20);
    for (const Coefficient& c : result.coefficients)
      CHECK(std::abs(c.value - truth().at(c.name)) < 4.0 * c.naive_standard_error.value());
    const FitResult again = fit(*tumbling_plates(), captures, options);
    CHECK(again.global_search->cost == result.global_search->cost);
    CHECK(again.coefficients[0].value == result.coefficients[0].value);
  }
}

TEST_CASE("a codebook answers inside its box, and the integrator outside, with the same derivatives") {
  const auto book = samara::codebooks::build(samara::codebooks::parse_plan(R"toml(
model = "falling_plate_nd"
[fixed]
inertia_ratio = 1.4
beta = 0.07142857142857142
B = 1.0
C_R = 3.0
A = 1.4
mu1 = 0.2
"vx(0)" = 0.3
"vy(0)" = -0.2
"x(0)" = 5.0
[box]
C_T = [1.0, 1.4]
"w(0)" = [-0.5, 0.5]
"theta(0)" = [-0.3, 0.3]
[time]
end = 0.3
[tolerance]
relative = 1e-4
)toml",
                                                                           "plan.toml"))
                        .book;
  std::map<std::string, double> held = plate(1.4);
  for (const auto& [name, value] :
       std::map<std::string, double>{{"C_R", 3.0}, {"A", 1.4}, {"mu1", 0.2}, {"vx(0)", 0.3}, {"vy(0)", -0.2}})
    held[name] = value;
  std::map<std::string, samara::models::Interval> box = {
      {"C_T", {0.5, 2.0}}, {"theta(0)", {-60.0, 60.0}}, {"w(0)", {-8.0, 8.0}}, {"x(0)", {-100.0, 100.0}}};
  const auto make = [&] { return step_trajectories(find_model("falling_plate_nd"), held, box, 0.005); };
  const auto mixed = mixed_trajectories(book, make());
  const auto exact = make();
  const std::vector<double> times = {0.1, 0.2, 0.3};
  const std::vector<std::string> outputs = {"x", "theta", "y"};
  const auto a = mixed->at(times, outputs);
  const auto b = exact->at(times, outputs);
  Eigen::MatrixXd values_a(3, 3), values_b(3, 3), by_a(3, 12), by_b(3, 12);
  // C_T, theta(0), w(0), x(0), in the order of their names.
  for (const std::vector<double>& q : {std::vector{1.2, 0.1, 0.2, 7.0}, std::vector{1.3, -0.2, -0.4, -3.0},
                                       std::vector{1.7, 0.9, 0.2, 7.0}}) {
    REQUIRE(a->evaluate(q, values_a, &by_a));
    REQUIRE(b->evaluate(q, values_b, &by_b));
    // 1e-4 of ranges of about 0.3; derivatives of that over a quarter of the box.
    CHECK((values_a - values_b).cwiseAbs().maxCoeff() < 1e-4);
    CHECK((by_a - by_b).cwiseAbs().maxCoeff() < 2e-3);
  }
  // Outside, it is the integrator to the bit.
  CHECK(values_a == values_b);

  held["A"] = 1.5;
  CHECK_THROWS_WITH(mixed_trajectories(book, make()), Catch::Contains("holds \"A\" at 1.4"));
}
