/// Outputs measured by sensors whose factor is not known.
#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "closed_form_family.h"
#include "files.h"
#include "fitted_values.h"
#include "plate_captures.h"
#include "residual_derivatives.h"
#include "samara/base/errors.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fitted_motion.h"
#include "samara/identification/fit/prediction.h"
#include "samara/identification/problem/fit_config.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using samara::models::find_model;

namespace {

/// theta = theta(0) + 7 t + c t^2.
class SpunFamily final : public ClosedFormFamily {
 public:
  SpunFamily()
      : ClosedFormFamily(
            {.model = "spun",
             .coordinates = {{"c", "rad/s^2", false, -9.0, 9.0}, {"theta(0)", "rad", true, -1.0, 1.0}},
             .outputs = {{"theta", "rad"}}},
            [](std::span<const double> q, double t, auto& values, auto* derivatives) {
              values << angle(q[0], q[1], t);
              if (derivatives) *derivatives << t * t, 1.0;
            }) {}
  static double angle(double c, double start, double t) { return start + 7.0 * t + c * t * t; }
};

/// Frames of a sensor that shows angles on one turn.
Capture spun_capture(const std::string& id, double gain, double offset, double start,
                     std::uint64_t seed = 0) {
  const std::vector<double> times = even_times(31, 2.0);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, seed > 0 ? 0.01 : 0.0);
  Capture capture;
  capture.id = id;
  capture.times = Eigen::Map<const Eigen::VectorXd>(times.data(), 31);
  Eigen::VectorXd theta(31);
  for (Eigen::Index k = 0; k < 31; ++k) {
    const double shown =
        gain * SpunFamily::angle(1.3, start, capture.times[k]) + offset + (seed > 0 ? noise(random) : 0.0);
    theta[k] = std::remainder(shown, 2.0 * std::numbers::pi);
  }
  capture.channels.push_back({"theta", "rad", theta});
  return capture;
}

FitOptions with_gain(double lower, double upper) {
  FitOptions options;
  options.loss = {.kind = LossKind::none, .scales = {{"theta", 0.01}}};
  options.measurement.gains["theta"] = {lower, upper};
  options.starts.count = 1;
  return options;
}

}  // namespace

TEST_CASE("gains of a sensor that shows angles on one turn are found") {
  const SpunFamily family;
  FitOptions options = with_gain(0.9, 1.1);
  options.unknowns.fixed["c"] = 1.3;
  SECTION("of each capture its own") {
    const std::vector captures = {spun_capture("a", 1.03, 0.0, 0.4), spun_capture("b", 0.97, 0.0, -0.2)};
    const FitResult result = fit(family, captures, options);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK_THAT(own_of(result, 0, "gain of theta").value, WithinAbs(1.03, 1e-9));
    CHECK_THAT(own_of(result, 1, "gain of theta").value, WithinAbs(0.97, 1e-9));
    CHECK_THAT(own_of(result, 1, "theta(0)").value, WithinAbs(-0.2, 1e-8));
    CHECK(result.cost < 1e-12);
  }
  SECTION("one of all, with offsets where the start is known") {
    options.unknowns.shared = {"gain of theta"};
    options.unknowns.fixed["theta(0)"] = 0.4;
    options.unknowns.offsets = {"theta"};
    const std::vector captures = {spun_capture("a", 1.03, 0.2, 0.4), spun_capture("b", 1.03, -0.1, 0.4)};
    const FitResult result = fit(family, captures, options);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK_THAT(shared_of(result, "gain of theta").value, WithinAbs(1.03, 1e-9));
    CHECK_THAT(own_of(result, 0, "offset of theta").value, WithinAbs(0.2, 1e-8));
    CHECK_THAT(own_of(result, 1, "offset of theta").value, WithinAbs(-0.1, 1e-8));
  }
  SECTION("beside a delay") {
    options.unknowns.fixed["theta(0)"] = 0.4;
    options.measurement.delay = samara::models::Interval{0.0, 0.2};
    Capture capture = spun_capture("late", 1.03, 0.0, 0.4);
    for (Eigen::Index k = 0; k < 31; ++k)
      capture.channels[0].values[k] = 1.03 * SpunFamily::angle(1.3, 0.4, capture.times[k] + 0.07);
    const FitResult result = fit(family, std::vector{capture}, options);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK_THAT(own_of(result, 0, "gain of theta").value, WithinAbs(1.03, 1e-8));
    CHECK_THAT(own_of(result, 0, "delay").value, WithinAbs(0.07, 1e-8));
  }
}

TEST_CASE("what a sensor's factor is known to weighs against what the captures say") {
  // With c and theta(0) held the model is linear in the gain: frames say 1.03 with a weight of
  // sum theta^2/scale^2, the prior says 1 with 1/deviation^2; the minimum is their weighted mean.
  FitOptions options = with_gain(0.9, 1.1);
  options.unknowns.fixed = {{"c", 1.3}, {"theta(0)", 0.4}};
  options.loss.scales["theta"] = 1.0;
  options.priors.coordinates["gain of theta"] = {.mean = 1.0, .deviation = 0.02};
  const Capture capture = spun_capture("a", 1.03, 0.0, 0.4);
  double frames = 0.0;
  for (const double t : capture.times) frames += std::pow(SpunFamily::angle(1.3, 0.4, t), 2);
  const FitResult result = fit(SpunFamily(), std::vector{capture}, options);
  const double prior = 1.0 / (0.02 * 0.02);
  CHECK_THAT(own_of(result, 0, "gain of theta").value,
             WithinAbs((1.03 * frames + prior) / (frames + prior), 1e-8));
}

TEST_CASE("a gain that a coefficient makes up for is said not to be determined") {
  const BrakedFamily family;
  const std::vector<double> times = even_times(25, 1.5);
  std::vector<Capture> captures;
  for (const double v0 : {0.8, 1.1})
    captures.push_back(make_capture(fmt::format("{} m/s", v0), times, BrakedFamily::depths(1.4, v0, times)));
  FitOptions options;
  options.measurement.gains["x"] = {0.8, 1.2};
  options.starts.count = 1;
  const FitResult own = fit(family, captures, options);
  CHECK(own.warnings.has(WarningKind::undetermined, "does not determine its gain of x"));
  options.unknowns.fixed["v(0)"] = 0.8;
  const FitResult known = fit(family, std::vector{captures[0]}, options);
  CHECK_FALSE(known.warnings.has(WarningKind::undetermined, "gain of x"));
}

// 300 fits of three captures: the share of 95 % intervals that hold the truth scatters by 1.3 %.
TEST_CASE("errors of gains hold the truth as often as they say") {
  constexpr int kSeeds = 300;
  FitOptions options = with_gain(0.8, 1.2);
  options.unknowns.shared = {"gain of theta"};
  options.unknowns.box["c"] = {1.0, 1.6};
  options.priors.coordinates["c"] = {.mean = 1.3, .deviation = 0.01};
  int held = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::vector<Capture> captures;
    for (int c = 0; c < 3; ++c) {
      captures.push_back(spun_capture(std::to_string(c), 1.03, 0.0, 0.2 * c - 0.2,
                                      static_cast<std::uint64_t>(3 * seed + c + 1)));
    }
    // What is known of c is drawn as it is said.
    std::mt19937_64 random(static_cast<std::uint64_t>(10000 + seed));
    options.priors.coordinates["c"].mean = std::normal_distribution<double>(1.3, 0.01)(random);
    const FitResult result = fit(SpunFamily(), captures, options);
    REQUIRE(result.status == samara::Termination::converged);
    const Coefficient& gain = shared_of(result, "gain of theta");
    held += std::abs(gain.value - 1.03) < 1.96 * gain.naive_standard_error.value() ? 1 : 0;
  }
  CHECK_THAT(held, WithinAbs(0.95 * kSeeds, 4.0 * 0.013 * kSeeds));
}

TEST_CASE("predictions and fitted motions show what the sensor would") {
  FitOptions options = with_gain(0.8, 1.2);
  options.unknowns.fixed["c"] = 1.3;
  options.unknowns.shared = {"gain of theta"};
  const std::vector captures = {spun_capture("a", 1.03, 0.0, 0.4), spun_capture("b", 1.03, 0.0, -0.2)};
  const FitResult result = fit(SpunFamily(), captures, options);
  const auto motion = fitted_motion(SpunFamily(), options, result, 0, {0.5, 3.0}, {"theta"});
  REQUIRE(motion.has_value());
  CHECK_THAT((*motion)(1, 0), WithinAbs(1.03 * SpunFamily::angle(1.3, 0.4, 3.0), 1e-6));
  const std::vector left_out = {spun_capture("d", 1.03, 0.0, 0.1)};
  const auto scores = predict_left_out(SpunFamily(), result, left_out, options, {.span = 0.8, .ahead = 1.0});
  REQUIRE_FALSE(scores.empty());
  for (const PredictionScore& score : scores) {
    if (score.predictor == "model") CHECK(score.median < 1e-6);
  }
}

TEST_CASE("gains go through cameras that turn, and through joins of segments") {
  std::map<std::string, double> values = {{"inertia_ratio", 1.4}, {"beta", 1.0 / 14.0}, {"B", 1.0},
                                          {"C_T", 1.2},           {"A", 1.4},           {"mu1", 0.2}};
  std::map<std::string, samara::models::Interval> box = {{"C_R", {1.0, 9.0}}, {"theta(0)", {-60.0, 60.0}}};
  for (const char* name : {"vx(0)", "vy(0)", "w(0)"}) box[name] = {-8.0, 8.0};
  const auto family = step_trajectories(find_model("falling_plate_nd"), values, box, 0.02);
  values["C_R"] = 3.14159;
  const std::vector<double> times = plate_times(60, 20.0);
  Eigen::MatrixXd states = plate_states(values, times);
  states.col(3) *= 1.05;                                               // theta
  states.col(4) = 0.9 * (states.col(4).array() - states(0, 4)) + 0.5;  // x
  const std::vector captures = {seen_plate(times, states, 0.0, 1)};
  FitOptions options;
  options.loss = {.kind = LossKind::none, .scales = {{"x", 0.01}, {"y", 0.01}, {"theta", 0.01}}};
  options.segments.length = 1.0;
  options.starts.count = 1;
  options.measurement.gains = {{"theta", {0.8, 1.2}}, {"x", {0.8, 1.2}}};
  SECTION("with exact derivatives") {
    for (const bool turned : {false, true}) {
      if (turned) options.camera = {.rotation = 0.05, .angles = {{"theta"}}};
      for (const bool shared_gain : {false, true}) {
        options.unknowns.shared.clear();
        if (shared_gain) options.unknowns.shared = {"gain of x"};
        const FitProblem problem = make_problem(family->info(), captures, options);
        SegmentResidual residual(*family, problem, problem.segments[1]);
        Eigen::VectorXd shared = Eigen::VectorXd::Constant(problem.shared_count(), 1.1);
        shared[0] = 3.0;
        const Eigen::VectorXd own = Eigen::VectorXd::Constant(problem.own_count(), 0.7);
        check_derivatives(residual, shared, own, 0.8 * own);
      }
    }
  }
  SECTION("and are found") {
    const FitResult result = fit(*family, captures, options);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK_THAT(own_of(result, 0, "gain of theta").value, WithinAbs(1.05, 1e-4));
    CHECK_THAT(own_of(result, 0, "gain of x").value, WithinAbs(0.9, 1e-4));
    CHECK_THAT(own_of(result, 0, "offset of x").value, WithinAbs(0.5, 1e-3));
    CHECK_THAT(shared_of(result, "C_R").value, WithinAbs(3.14159, 1e-3));
  }
}

TEST_CASE("gains that mean nothing are refused") {
  const BrakedFamily family;
  const std::vector<double> times = even_times(25, 1.5);
  const std::vector captures = {make_capture("a", times, BrakedFamily::depths(1.4, 1.0, times))};
  const auto refusal = [&](const FitOptions& options) {
    return error_of<samara::ArgumentError>([&] { fit(family, captures, options); });
  };
  FitOptions options;
  options.measurement.gains["theta"] = {0.9, 1.1};
  CHECK_THAT(refusal(options), Contains("gain: \"theta\" is not among the compared outputs (x)"));
  options.measurement.gains = {{"x", {1.1, 0.9}}};
  CHECK_THAT(refusal(options), Contains("the range of the gain of \"x\" goes from 1.1 to 0.9"));
  options.measurement.gains = {{"x", {std::nan(""), 0.9}}};
  CHECK_THAT(refusal(options), Contains("the range of the gain of \"x\" goes from nan to 0.9"));
  options.measurement.gains = {{"x", {-1.0, 1.0}}};
  CHECK_THAT(refusal(options), Contains("with a gain of 0 nothing is measured"));
  options.measurement.gains = {{"x", {0.9, 1.1}}};
  options.camera.scale = 0.02;
  CHECK_THAT(refusal(options), Contains("gain: \"x\" is scaled by the camera already, and the two are one"));

  const ConfigNames names = config_names(find_model("vertical_fall")->info());
  const auto error = [&](const std::string& text) {
    return error_of<samara::InputError>([&] { parse_fit_config(text, "fit.toml", names); });
  };
  CHECK_THAT(error("gain = { speed = { range = [0.9, 1.1] } }"), Contains("speed"));
  CHECK_THAT(error("gain = { v = { range = [-1, 1] } }"), Contains("with a gain of 0 nothing is measured"));
  CHECK_THAT(error("gain = { v = { range = [1.1, 0.9] } }"), Contains("[lower, upper] with lower < upper"));
  const FitOptions read = parse_fit_config(
      "gain = { v = { range = [0.9, 1.1] } }\n[priors]\n\"gain of v\" = { mean = 1, deviation = 0.02 }\n",
      "fit.toml", names);
  CHECK(read.measurement.gains.at("v").upper == 1.1);
  CHECK(read.priors.coordinates.at("gain of v").deviation == 0.02);
}
