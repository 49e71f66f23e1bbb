/// Captures whose clock does not read 0 at the release.
#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "files.h"
#include "fitted_values.h"
#include "plate_captures.h"
#include "residual_derivatives.h"
#include "samara/base/errors.h"
#include "samara/identification/fit/delay_check.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fitted_motion.h"
#include "samara/identification/fit/prediction.h"
#include "samara/identification/problem/measurement.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/report/fit_report.h"
#include "samara/identification/report/read_fit.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using samara::models::find_model;

namespace {

constexpr double kBrake = 1.4;
constexpr double kSpeed = 1.2;

/// A body released with a known speed, filmed from `begin` on by a clock that is `delay` behind.
Capture late_capture(const std::string& id, double delay, double begin = 0.0, int averaged = 1) {
  const std::vector<double> times = even_times(31, 1.5);
  const double interval = times[1];
  Eigen::VectorXd x = Eigen::VectorXd::Zero(31);
  std::vector<double> clock;
  for (std::size_t k = 0; k < times.size(); ++k) {
    clock.push_back(begin + times[k]);
    for (int j = -averaged / 2; j <= averaged / 2; ++j) {
      // Means begin half their width after the start of the trajectory.
      const double since = clock[k] + (averaged / 2 + j) * interval + delay;
      x[static_cast<Eigen::Index>(k)] += BrakedFamily::depth(kBrake, kSpeed, since) / averaged;
    }
  }
  return make_capture(id, clock, x);
}

/// The speed of the release is known, and where it was.
FitOptions released(double lower, double upper) {
  FitOptions options;
  options.loss = {.kind = LossKind::none, .length_scale = 1e-3};
  options.unknowns.fixed["v(0)"] = kSpeed;
  options.unknowns.offsets = std::vector<std::string>{};
  options.measurement.delay = samara::models::Interval{lower, upper};
  options.starts.count = 1;
  return options;
}

std::string refusal(const std::vector<Capture>& captures, const FitOptions& options) {
  return error_of<samara::ArgumentError>([&] { fit(BrakedFamily(), captures, options); });
}

}  // namespace

TEST_CASE("delays of captures are found, where the release is known") {
  const BrakedFamily family;
  SECTION("of each its own") {
    const std::vector captures = {late_capture("a", 0.013), late_capture("b", 0.071),
                                  late_capture("c", 0.0042)};
    const FitResult result = fit(family, captures, released(0.0, 0.1));
    REQUIRE(result.status == samara::Termination::converged);
    CHECK_THAT(shared_of(result, "k").value, WithinAbs(kBrake, 1e-6));
    CHECK_THAT(own_of(result, 0, "delay").value, WithinAbs(0.013, 1e-6));
    CHECK_THAT(own_of(result, 1, "delay").value, WithinAbs(0.071, 1e-6));
    CHECK_THAT(own_of(result, 2, "delay").value, WithinAbs(0.0042, 1e-6));
    CHECK(own_of(result, 0, "delay").unit == "s");
  }
  SECTION("one of all captures, and negative where the clock was started early") {
    FitOptions options = released(-0.2, 0.2);
    options.unknowns.shared = {"delay"};
    const std::vector captures = {late_capture("a", -0.11, 0.3), late_capture("b", -0.11, 0.4)};
    const FitResult result = fit(family, captures, options);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK_THAT(shared_of(result, "delay").value, WithinAbs(-0.11, 1e-6));
    CHECK_THAT(shared_of(result, "k").value, WithinAbs(kBrake, 1e-6));
    CHECK(shared_of(result, "delay").lower == -0.2);
    CHECK(result.captures[0].nuisances.empty());
  }
  SECTION("by frames that are means of five") {
    FitOptions options = released(0.0, 0.1);
    options.compared.averaged_frames = 5;
    const std::vector captures = {late_capture("a", 0.013, 0.0, 5), late_capture("b", 0.071, 0.0, 5)};
    const FitResult result = fit(family, captures, options);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK_THAT(own_of(result, 0, "delay").value, WithinAbs(0.013, 1e-6));
    CHECK_THAT(own_of(result, 1, "delay").value, WithinAbs(0.071, 1e-6));
  }
  SECTION("through a camera of another scale") {
    FitOptions options = released(0.0, 0.1);
    options.camera.scale = 10.0;  // as good as free
    std::vector captures = {late_capture("a", 0.013), late_capture("b", 0.071)};
    captures[1].channels[0].values *= 1.07;
    const FitResult result = fit(family, captures, options);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK_THAT(own_of(result, 1, "delay").value, WithinAbs(0.071, 1e-5));
    CHECK_THAT(own_of(result, 1, "scale").value, WithinAbs(1.07, 1e-5));
  }
  SECTION("or held, or known from a label") {
    FitOptions options = released(0.0, 0.1);
    std::vector captures = {late_capture("a", 0.013), late_capture("b", 0.071)};
    captures[0].labels["late"] = "13";
    captures[1].labels["late"] = "71";
    options.unknowns.known["delay"] = {"late", 1e-3};
    const FitResult known = fit(family, captures, options);
    CHECK_THAT(shared_of(known, "k").value, WithinAbs(kBrake, 1e-6));
    CHECK(known.cost < 1e-12);
    options.unknowns.known.clear();
    options.unknowns.fixed["delay"] = 0.013;
    const FitResult held = fit(family, std::vector{captures[0]}, options);
    CHECK_THAT(shared_of(held, "k").value, WithinAbs(kBrake, 1e-6));
    CHECK(held.fixed.at("delay") == 0.013);
  }
}

TEST_CASE("delays of captures are found by places and attitudes in space") {
  std::map<std::string, double> held = {
      {"a", 0.035},    {"b", 0.02},    {"c", 1e-4},  {"density", 1200.0}, {"C_D0", 0.05},
      {"C_D90", 0.31}, {"C_T", 0.91},  {"C_w", 2.0}, {"qw(0)", 0.9},      {"qx(0)", std::sqrt(0.19)},
      {"ux(0)", 0.4},  {"wx(0)", 10.0}};
  const auto family = step_trajectories(find_model("immersed_body"), held, {{"C_R", {0.3, 3.0}}}, 1e-3);
  const std::vector<double> outputs_times = even_times(60, 0.25);
  const std::vector<std::string> outputs = {"x", "y", "z", "qw", "qx", "qy", "qz"};
  std::vector<Capture> captures;
  for (const double delay : {0.0031, 0.0087}) {
    std::vector<double> times = outputs_times;
    for (double& time : times) time += delay;
    const Eigen::MatrixXd seen = trajectory(*family, std::vector{1.2}, times, outputs).values;
    Capture capture;
    capture.id = fmt::format("card {} s late", delay);
    capture.times = Eigen::Map<const Eigen::VectorXd>(outputs_times.data(), 60);
    for (std::size_t o = 0; o < outputs.size(); ++o)
      capture.channels.push_back({outputs[o], o < 3 ? "m" : "1", seen.col(static_cast<Eigen::Index>(o))});
    captures.push_back(std::move(capture));
  }
  FitOptions options;
  options.loss = {.kind = LossKind::none, .length_scale = 1e-3, .attitude_scale = 0.02};
  options.unknowns.offsets = std::vector<std::string>{};
  options.measurement.delay = samara::models::Interval{0.0, 0.012};
  options.starts.count = 1;
  const FitResult result = fit(*family, captures, options);
  REQUIRE(result.status == samara::Termination::converged);
  CHECK_THAT(shared_of(result, "C_R").value, WithinAbs(1.2, 1e-5));
  CHECK_THAT(own_of(result, 0, "delay").value, WithinAbs(0.0031, 1e-7));
  CHECK_THAT(own_of(result, 1, "delay").value, WithinAbs(0.0087, 1e-7));

  SECTION("with exact derivatives") {
    const FitProblem problem = make_problem(family->info(), captures, options);
    SegmentResidual residual(*family, problem, problem.segments[0]);
    check_derivatives(residual, Eigen::VectorXd::Constant(1, 1.1), Eigen::VectorXd::Constant(1, 0.005), {});
  }
}

TEST_CASE("segments of a motion join with a delay, which shifts frames and not their ends") {
  const std::map<std::string, double> held = {{"inertia_ratio", 1.4}, {"beta", 1.0 / 14.0}, {"B", 1.0},
                                              {"C_T", 1.2},           {"A", 1.4},           {"mu1", 0.2}};
  std::map<std::string, double> values = held;
  values["C_R"] = 3.14159;
  constexpr double kLate = 0.13;
  const std::vector<double> times = plate_times(60, 20.0 + kLate);
  const Eigen::MatrixXd states = plate_states(values, times);
  Capture capture = seen_plate(times, states, 0.0, 1);
  std::map<std::string, samara::models::Interval> box = {{"C_R", {1.0, 9.0}}, {"theta(0)", {-60.0, 60.0}}};
  for (const char* name : {"vx(0)", "vy(0)", "w(0)"}) box[name] = {-8.0, 8.0};
  const auto family = step_trajectories(find_model("falling_plate_nd"), held, box, 0.02);
  FitOptions options;
  options.loss = {.kind = LossKind::none, .scales = {{"x", 0.01}, {"y", 0.01}, {"theta", 0.01}}};
  options.segments.length = 1.0;
  options.starts.count = 1;

  SECTION("its residuals have exact derivatives, with negative delays, means of frames and gains, too") {
    for (const int averaged : {1, 3}) {
      options.compared.averaged_frames = averaged;
      options.measurement.delay = samara::models::Interval{-0.3, 0.2};
      options.measurement.gains = {{"theta", {0.9, 1.1}}, {"x", {0.9, 1.1}}};
      const FitProblem problem = make_problem(family->info(), std::vector{capture}, options);
      CHECK_THAT(problem.segments[1].lead,
                 WithinAbs(0.3 + 0.5 * (averaged - 1) * times[1] - 0.5 * (averaged - 1) * times[0], 1e-9));
      SegmentResidual residual(*family, problem, problem.segments[1]);
      Eigen::VectorXd own = Eigen::VectorXd::Constant(problem.own_count(), 0.7);
      own[static_cast<Eigen::Index>(*position(problem.own, "delay"))] = -0.12;
      Eigen::VectorXd next = 0.8 * own;
      check_derivatives(residual, Eigen::VectorXd::Constant(1, 3.0), own, next);
    }
  }
  SECTION("and it is found where the start is known") {
    // Beforehand: the states at the release, to 1e-4.
    const Eigen::MatrixXd release = plate_states(values, {20.0});
    const std::array names = {"vx(0)", "vy(0)", "w(0)", "theta(0)"};
    for (std::size_t k = 0; k < names.size(); ++k)
      options.priors.coordinates[names[k]] = {.mean = release(0, static_cast<Eigen::Index>(k)),
                                              .deviation = 1e-4};
    options.measurement.delay = samara::models::Interval{0.0, 0.3};
    const FitResult result = fit(*family, std::vector{capture}, options);
    REQUIRE(result.status == samara::Termination::converged);
    REQUIRE(result.join_defect.has_value());
    CHECK(*result.join_defect < 0.01);
    CHECK_THAT(own_of(result, 0, "delay").value, WithinAbs(kLate, 1e-4));
    CHECK_THAT(shared_of(result, "C_R").value, WithinAbs(3.14159, 1e-3));
  }
}

TEST_CASE("a delay that another start makes up for is said not to be determined") {
  FitOptions options = released(0.0, 0.1);
  options.unknowns.fixed.clear();  // v(0) exp(-k delay) and the offset are all that frames see
  options.unknowns.offsets.reset();
  const std::vector captures = {late_capture("a", 0.05), late_capture("b", 0.02)};
  SECTION("of each capture's own") {
    const FitResult result = fit(BrakedFamily(), captures, options);
    CHECK(result.warnings.has(WarningKind::undetermined, "capture \"a\" does not determine its delay"));
    CHECK_FALSE(own_of(result, 0, "delay").standard_error.has_value());
  }
  SECTION("or hardly, where little is known of the start") {
    // 1 m/s of the speed is 1/(k v(0)) = 0.6 s of the delay.
    options.priors.coordinates["v(0)"] = {.mean = kSpeed, .deviation = 1.0};
    const FitResult result = fit(BrakedFamily(), captures, options);
    CHECK(result.warnings.has(
        WarningKind::undetermined,
        "captures that say little about their delay, with a standard error of half its range or "
        "more: 2 of 2, \"a\", \"b\""));
    CHECK_THAT(own_of(result, 0, "delay").standard_error.value(), WithinAbs(1.0 / (kBrake * kSpeed), 0.05));
  }
  SECTION("of all captures") {
    options.unknowns.shared = {"delay"};
    const FitResult result = fit(BrakedFamily(), captures, options);
    CHECK(result.status == samara::Termination::not_determined);
    CHECK(result.warnings.has(WarningKind::undetermined, "the captures do not determine delay"));
  }
}

// 300 fits of four captures, noise of 1 mm: the share of 95 % intervals that hold the truth scatters by 1.3 %,
// that of 1200 delays by 0.6 %, and more where those of a fit go together.
TEST_CASE("errors of delays and of coefficients beside them hold the truth as often as they say") {
  constexpr int kSeeds = 300;
  FitOptions options = released(-0.05, 0.15);
  int held_k = 0, held_delays = 0;
  double pulls = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    std::vector<Capture> captures;
    for (int c = 0; c < 4; ++c) {
      captures.push_back(late_capture(std::to_string(c), 0.02 * c, 0.1));
      add_noise(captures.back(), 1e-3, random);
    }
    const FitResult result = fit(BrakedFamily(), captures, options);
    REQUIRE(result.status == samara::Termination::converged);
    const Coefficient& k = shared_of(result, "k");
    held_k += std::abs(k.value - kBrake) < 1.96 * k.naive_standard_error.value() ? 1 : 0;
    for (std::size_t c = 0; c < 4; ++c) {
      const Nuisance& delay = own_of(result, c, "delay");
      const double pull = (delay.value - 0.02 * static_cast<double>(c)) / delay.standard_error.value();
      held_delays += std::abs(pull) < 1.96 ? 1 : 0;
      pulls += pull * pull;
    }
  }
  CHECK_THAT(held_k, WithinAbs(0.95 * kSeeds, 4.0 * 0.013 * kSeeds));
  CHECK_THAT(held_delays, WithinAbs(0.95 * 4 * kSeeds, 4.0 * 0.013 * 2 * kSeeds));
  CHECK_THAT(std::sqrt(pulls / (4 * kSeeds)), WithinAbs(1.0, 0.08));
}

TEST_CASE("the file of a fit has its delays, and predictions find those of captures left out") {
  FitOptions options = released(0.0, 0.1);
  std::vector captures = {late_capture("a", 0.013), late_capture("b", 0.013), late_capture("c", 0.013)};
  std::mt19937_64 random(5);
  for (Capture& capture : captures) add_noise(capture, 1e-4, random);
  SECTION("own ones") {
    const FitResult result = fit(BrakedFamily(), captures, options);
    CHECK_THAT(fit_json(result), Contains("\"name\": \"delay\""));
    CHECK_THAT(fit_text(result), Contains("delay [s]"));
    const std::vector left_out = {late_capture("d", 0.08)};
    const auto scores =
        predict_left_out(BrakedFamily(), result, left_out, options, {.span = 0.6, .ahead = 0.8});
    REQUIRE_FALSE(scores.empty());
    // 12 frames of 0.1 mm tell the delay to 0.1 ms; without it, x would be off by 40 mm.
    for (const PredictionScore& score : scores) {
      if (score.predictor == "model") CHECK(score.median < 3e-4);
    }
    const auto motion = fitted_motion(BrakedFamily(), options, result, 0, {0.5, 1.7}, {"x"});
    REQUIRE(motion.has_value());
    CHECK_THAT((*motion)(1, 0), WithinAbs(BrakedFamily::depth(kBrake, kSpeed, 1.713), 3e-4));
  }
  SECTION("one of all, which holds for those left out, with profile, bootstrap and posterior") {
    options.unknowns.shared = {"delay"};
    options.uncertainty.profiles = true;
    options.uncertainty.bootstrap.replicates = 20;
    options.uncertainty.posterior.samples = 400;
    const FitResult result = fit(BrakedFamily(), captures, options);
    REQUIRE(result.find_profile("delay") != nullptr);
    CHECK(result.find_profile("delay")->shape == ProfileShape::identified);
    REQUIRE(result.bootstrap.has_value());
    CHECK(result.bootstrap->converged == 20);
    REQUIRE(result.posterior.has_value());
    const auto drawn = std::ranges::find(result.posterior->unknowns, "delay", &PosteriorUnknown::name);
    REQUIRE(drawn != result.posterior->unknowns.end());
    CHECK_THAT(drawn->mean, WithinAbs(0.013, 1e-3));
    const TemporaryDirectory files;
    const FitResult read = read_fit(files.put("fit.json", fit_json(result)));
    CHECK(shared_of(read, "delay").value == shared_of(result, "delay").value);
    const std::vector left_out = {late_capture("d", 0.013)};
    for (const PredictionScore& score :
         predict_left_out(BrakedFamily(), read, left_out, options, {.span = 0.6, .ahead = 0.8})) {
      if (score.predictor == "model") CHECK(score.median < 3e-4);
    }
  }
}

TEST_CASE("frames too far apart to be shifted are told") {
  // A frame and a half to a swing of the plate, which turns by 5 rad between frames.
  const std::map<std::string, double> fixed = {
      {"inertia_ratio", 1.4}, {"beta", 1.0 / 14.0}, {"B", 1.0},     {"C_T", 1.2},   {"A", 1.4},
      {"mu1", 0.2},           {"theta(0)", 0.3},    {"vx(0)", 0.0}, {"vy(0)", 0.0}, {"w(0)", 0.1}};
  const auto family = step_trajectories(find_model("falling_plate_nd"), fixed, {{"C_R", {1.0, 9.0}}}, 0.01);
  FitOptions options;
  options.loss = {.kind = LossKind::none, .scales = {{"theta", 0.01}, {"x", 0.01}, {"y", 0.01}}};
  options.measurement.delay = samara::models::Interval{0.0, 1.0};
  for (const double interval : {0.2, 4.0}) {
    const std::vector<double> times = even_times(12, 11.0 * interval);
    const Eigen::MatrixXd seen = trajectory(*family, std::vector{3.0}, times, {"theta", "x", "y"}).values;
    Capture capture;
    capture.id = "rare";
    capture.times = Eigen::Map<const Eigen::VectorXd>(times.data(), 12);
    const std::array names = {"theta", "x", "y"};
    for (Eigen::Index o = 0; o < 3; ++o)
      capture.channels.push_back({names[static_cast<std::size_t>(o)], "1", seen.col(o)});
    const std::vector captures = {capture};
    const FitProblem problem = make_problem(family->info(), captures, options);
    std::vector<SegmentResidual> residuals = make_residuals(*family, problem);
    FitPoint point;
    point.shared = Eigen::VectorXd::Constant(1, 3.0);
    point.own = {Eigen::VectorXd::Constant(problem.own_count(), 0.0)};
    point.own[0][static_cast<Eigen::Index>(*position(problem.own, "delay"))] = 0.4;
    FitResult result;
    add_delay_warning(*family, problem, residuals, point, result);
    CHECK(result.warnings.has(WarningKind::captures, "too far apart to be shifted") == (interval > 1.0));
  }
}

TEST_CASE("delays that mean nothing are refused") {
  const std::vector captures = {late_capture("a", 0.05)};
  CHECK_THAT(refusal(captures, released(0.1, 0.0)), Contains("the range of the delay goes from 0.1 to 0"));
  CHECK_THAT(refusal(captures, released(std::nan(""), 0.1)),
             Contains("the range of the delay goes from nan"));
  CHECK_THAT(refusal(captures, released(0.0, INFINITY)), Contains("an interval with a length was expected"));
  CHECK_THAT(
      refusal(captures, released(-0.02, 0.1)),
      Contains(
          "capture \"a\" has a frame 0 s after the start of the motion, and a delay of -0.02 s to 0.1 s") &&
          Contains("a delay of 0 s or more was expected"));
  SECTION("where the codebook ends before them") {
    BrakedFamily family;
    family.mutable_info().end_time = 1.55;
    CHECK_THAT(
        error_of<samara::ArgumentError>([&] { fit(family, captures, released(0.0, 0.1)); }),
        Contains(
            "capture \"a\" lasts 1.5 s, and with a delay of 0 s to 0.1 s it asks for 1.6 s, but the closed "
            "form ends at 1.55 s"));
    CHECK_NOTHROW(fit(family, captures, released(0.0, 0.05)));
  }
  SECTION("of spans, of a held value outside the range, and of a model that has a delay itself") {
    FitOptions options = released(0.0, 0.1);
    options.compared.span = 0.5;
    options.compared.stride = 0.5;
    CHECK_THAT(refusal(captures, options), Contains("delay: spans of a capture (stride)"));
    options = released(0.0, 0.1);
    const FitResult fitted = fit(BrakedFamily(), captures, options);
    const std::vector left_out = {late_capture("b", 0.02)};
    const PredictionOptions strided{.span = 0.5, .ahead = 0.2, .stride = 0.3};
    CHECK_THAT(error_of<samara::ArgumentError>(
                   [&] { predict_left_out(BrakedFamily(), fitted, left_out, options, strided); }),
               Contains("stride: a span that is predicted starts where it is cut"));
    options.unknowns.fixed["delay"] = 0.2;
    CHECK_THAT(refusal(captures, options), Contains("\"delay\" is fixed at 0.2; a value in the box"));
    BrakedFamily family;
    family.mutable_info().coordinates[0].name = "delay";
    CHECK_THAT(error_of<samara::ArgumentError>([&] { fit(family, captures, released(0.0, 0.1)); }),
               Contains("\"delay\" is a coordinate of \"braked\" itself"));
  }
}
