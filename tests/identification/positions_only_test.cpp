#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fitted_motion.h"
#include "samara/identification/problem/chart.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/smoothing/flutter.h"
#include "samara/identification/solve/starts/attitude_guess.h"
#include "samara/models/integrators/rotations.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kInterval = 0.01;

/// What a source gives that replaces each frame by the mean of five.
Capture braked_means(const std::vector<double>& times, double k, double v0) {
  Eigen::VectorXd means = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(times.size()));
  for (std::size_t row = 0; row < times.size(); ++row) {
    for (int j = -2; j <= 2; ++j) {
      means[static_cast<Eigen::Index>(row)] += BrakedFamily::depth(k, v0, times[row] + j * kInterval) / 5.0;
    }
  }
  return make_capture("means", times, means);
}

std::vector<double> frames(double begin, int count) {
  std::vector<double> times;
  for (int k = 0; k < count; ++k) times.push_back(begin + k * kInterval);
  return times;
}

using Values = std::map<std::string, double>;

const Values& disc() {
  static const Values values = {
      {"a", 0.035}, {"b", 0.035}, {"c", 5.2e-5}, {"density", 1008.0}, {"wz(0)", 0.0}};
  return values;
}

const Values& disc_coefficients() {
  static const Values values = {{"C_D0", 0.2}, {"C_D90", 3.0}, {"C_T", 1.3}, {"C_R", 0.9}, {"C_w", 2.0}};
  return values;
}

/// Spans of a fluttering disc, positions alone, each frame the mean of five.
std::vector<Capture> disc_spans(int count, int span_frames) {
  Values fixed = disc();
  fixed.insert(disc_coefficients().begin(), disc_coefficients().end());
  const double tilt = 0.3;
  fixed["qw(0)"] = std::cos(0.5 * tilt);
  fixed["qx(0)"] = std::sin(0.5 * tilt) * std::cos(0.4);
  fixed["qy(0)"] = std::sin(0.5 * tilt) * std::sin(0.4);
  const samara::models::ParametricModel model(samara::models::find_model("immersed_body"), fixed, {});
  const std::vector<double> times = frames(0.0, 40 + count * span_frames);
  const auto trajectory = samara::models::integrate(model, {}, times);
  std::vector<Capture> spans;
  for (int n = 0; n < count; ++n) {
    Capture span;
    span.id = std::to_string(n);
    const std::vector<double> own = frames(0.0, span_frames);
    span.times = Eigen::Map<const Eigen::VectorXd>(own.data(), span_frames);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      Eigen::VectorXd means(span_frames);
      for (int k = 0; k < span_frames; ++k) {
        means[k] = trajectory.states.col(axis).segment(28 + n * span_frames + k, 5).mean();
      }
      span.channels.push_back({std::string(1, static_cast<char>('x' + axis)), "m", means});
    }
    spans.push_back(std::move(span));
  }
  return spans;
}

std::unique_ptr<samara::models::TrajectoryFamily> disc_family() {
  std::map<std::string, samara::models::Interval> box;
  for (const char* name : {"x(0)", "y(0)", "z(0)"}) box[name] = {-5.0, 5.0};
  for (const char* name : {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}) box[name] = {-1.1, 1.1};
  for (const char* name : {"ux(0)", "uy(0)", "uz(0)"}) box[name] = {-5.0, 5.0};
  for (const char* name : {"wx(0)", "wy(0)"}) box[name] = {-100.0, 100.0};
  for (const auto& [name, value] : disc_coefficients()) box[name] = {0.2 * value, 4.0 * value};
  return step_trajectories(samara::models::find_model("immersed_body"), disc(), box, 2.5e-3);
}

}  // namespace

TEST_CASE("frames that are means of five are met by the model's means, whose start lies two frames earlier") {
  const BrakedFamily family;
  const std::vector<double> times = frames(0.3, 40);
  const Capture capture = braked_means(times, 1.7, 0.9);
  FitOptions options;
  options.compared.averaged_frames = 5;
  options.unknowns.offsets = {{"x"}};
  options.segments.length = 10.0;
  const FitResult result = fit(family, std::vector{capture}, options);
  // The data are exact: only the convergence of the fit is left.
  CHECK_THAT(result.coefficients[0].value, WithinRel(1.7, 1e-6));
  CHECK_THAT(result.captures[0].start, WithinAbs(0.28, 1e-12));
  CHECK_THAT(result.captures[0].nuisances[0].value, WithinRel(0.9 * std::exp(-1.7 * 0.28), 1e-6));

  // And beyond the span, at the mean of frames there.
  const std::vector<double> later = frames(1.0, 3);
  const Capture truth = braked_means(later, 1.7, 0.9);
  const auto predicted = fitted_motion(family, options, result, 0, later, {"x"});
  REQUIRE(predicted);
  CHECK((predicted->col(0) - truth.channels[0].values).norm() < 1e-7);
}

TEST_CASE("joined segments of means join at their states, not at means") {
  const samara::models::ParametricModel coin(samara::models::find_model("vertical_fall"), coin_fixed(),
                                             {"C_D", "v(0)"});
  const std::vector<double> all = frames(0.0, 64);
  const auto trajectory = samara::models::integrate(coin, std::vector{1.1, 0.05}, all);
  Eigen::VectorXd means(60);
  for (Eigen::Index k = 0; k < means.size(); ++k) means[k] = trajectory.states.col(1).segment(k, 5).mean();
  const Capture capture = make_capture("means", frames(0.0, 60), means);
  FitOptions options;
  options.compared.averaged_frames = 5;
  options.segments.length = 0.2;
  options.starts.count = 1;
  const FitResult result = fit(*coin_family(), std::vector{capture}, options);
  REQUIRE(result.captures[0].segments == 3);
  REQUIRE(result.join_defect);
  CHECK(*result.join_defect < 1e-3);
  // The data are exact but for the integrators' 1e-10; joined at means, speeds at the joins would be wrong by
  // g times two frames, 0.2 m/s.
  CHECK_THAT(result.coefficients[0].value, WithinRel(1.1, 1e-4));
}

TEST_CASE("a mean of an even number of frames is refused") {
  CHECK_THROWS_WITH(validate(FitOptions{.compared = {.averaged_frames = 4}}),
                    Catch::Matchers::Contains("averaged_frames is 4"));
}

TEST_CASE("an axis moves by turns across it, and not about itself") {
  const Chart chart({Chart::Kind::linear, Chart::Kind::axis});
  REQUIRE(chart.size() == 5);
  REQUIRE(chart.directions() == 3);
  const std::array<double, 5> x = {2.0, 0.8, 0.36, -0.48, 0.0};
  const Eigen::Vector3d step(0.5, 0.2, -0.1);
  std::array<double, 5> y;
  chart.plus(x.data(), step.data(), y.data());
  Eigen::Vector3d back;
  chart.minus(y.data(), x.data(), back.data());
  CHECK((back - step).norm() < 1e-14);

  const Eigen::MatrixXd jacobian = chart.plus_jacobian(x.data());
  CHECK((chart.minus_jacobian(x.data()) * jacobian - Eigen::Matrix3d::Identity()).norm() < 1e-14);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double h = 1e-6;
    const Eigen::Vector3d small = h * Eigen::Vector3d::Unit(k);
    std::array<double, 5> moved;
    chart.plus(x.data(), small.data(), moved.data());
    for (Eigen::Index i = 0; i < 5; ++i) {
      const auto at = static_cast<std::size_t>(i);
      CHECK_THAT((moved[at] - x[at]) / h, WithinAbs(jacobian(i, k), 1e-5));  // first order: h
    }
  }
}

TEST_CASE("a plate's normal lies along what pushes it, and turns with it") {
  const Eigen::Vector3d push(3.0, -1.0, 8.0);
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, -0.5).normalized();
  const double rate = 4.0;
  const double later = 1e-4;
  const Eigen::Vector3d push_later = push + later * rate * axis.cross(push);
  const GuessedAttitude guess = guess_attitude(push, push_later, later, {.turning = true});
  const samara::models::Quaternion q = {guess.q_WB[0], guess.q_WB[1], guess.q_WB[2], guess.q_WB[3]};
  const Eigen::Vector3d n = samara::models::rotate(q, Eigen::Vector3d::UnitZ());
  CHECK((n - push.normalized()).norm() < 1e-14);
  const samara::models::Quaternion moved =
      samara::models::normalised({q[0] + later * guess.rate[0], q[1] + later * guess.rate[1],
                                  q[2] + later * guess.rate[2], q[3] + later * guess.rate[3]});
  // The product of two turns by 4e-4 rad is left out.
  CHECK((samara::models::rotate(moved, Eigen::Vector3d::UnitZ()) - push_later.normalized()).norm() < 1e-6);

  // Either side of the plate may be up: the guess takes the one that is.
  const GuessedAttitude other = guess_attitude(-push, -push_later, later, {});
  CHECK((other.q_WB - guess.q_WB).norm() < 1e-14);
  const GuessedAttitude tilted = guess_attitude(push, push_later, later, {.tilt_1 = 0.5});
  const samara::models::Quaternion t = {tilted.q_WB[0], tilted.q_WB[1], tilted.q_WB[2], tilted.q_WB[3]};
  CHECK_THAT(samara::models::rotate(t, Eigen::Vector3d::UnitZ()).dot(n), WithinAbs(std::cos(0.5), 1e-14));
}

TEST_CASE("coefficients of a disc are found from positions alone, smoothed by their source") {
  const std::vector<Capture> spans = disc_spans(6, 20);
  const auto family = disc_family();
  FitOptions options;
  options.compared.averaged_frames = 5;
  options.starts.round_body = true;
  options.segments.length = 10.0;
  options.starts.rounds = 2;
  options.starts.count = 1;
  options.solver.max_iterations = 60;
  for (const auto& [name, value] : disc_coefficients()) {
    options.starts.initial[name] = 1.3 * value;
    options.unknowns.log_scale.push_back(name);
  }
  const FitResult result = fit(*family, spans, options);
  for (const Coefficient& c : result.coefficients) {
    INFO(c.name << " " << c.value);
    // Without noise; Runge-Kutta steps of 2.5 ms err by some 1e-5 m. Edge-on drag is next to unknown.
    if (c.name != "C_D0") CHECK_THAT(c.value, WithinRel(disc_coefficients().at(c.name), 0.02));
  }
  for (const OutputRms& output : result.residuals) CHECK(output.rms < 5e-5);
}

TEST_CASE("a parameter may be each capture's own where start states are found") {
  const std::vector<Capture> captures = {coin_capture("a", 1.0, 0.05, 0.3), coin_capture("b", 1.3, 0.1, 0.2)};
  FitOptions options;
  options.unknowns.per_capture = {"C_D"};
  options.segments.length = 10.0;
  const FitResult result = fit(*coin_family(), captures, options);
  // The data are the integrator's own.
  CHECK_THAT(result.captures[0].nuisances[0].value, WithinRel(1.0, 1e-5));
  CHECK_THAT(result.captures[1].nuisances[0].value, WithinRel(1.3, 1e-5));
}

TEST_CASE("a round body in joined segments is refused") {
  FitOptions options;
  options.starts.round_body = true;
  options.segments.length = 0.1;
  CHECK_THROWS_WITH(fit(*disc_family(), disc_spans(1, 40), options), Catch::Matchers::Contains("round_body"));
}

TEST_CASE("flutter is found in a drifting ellipse") {
  const int count = 90;
  Eigen::VectorXd times(count);
  Eigen::MatrixX3d positions(count, 3);
  for (int k = 0; k < count; ++k) {
    const double t = k / 30.0;
    times[k] = t;
    const double phase = 2.0 * std::numbers::pi * 2.06 * t + 0.7;
    positions.row(k) << 0.01 * t + 0.002 * t * t + 3e-3 * std::cos(phase), -0.02 * t + 4e-3 * std::cos(phase),
        0.2 - 0.041 * t + 1e-3 * std::cos(2.0 * phase);
  }
  positions(17, 1) = std::nan("");
  const auto found = flutter(times, positions);
  REQUIRE(found);
  CHECK_THAT(found->frequency, WithinRel(2.06, 1e-4));  // the search's own tolerance
  CHECK_THAT(found->amplitude, WithinRel(5e-3, 1e-3));
  // The second harmonic of the heights leaves 1 mm over 3 s.
  CHECK_THAT(found->fall_speed, WithinAbs(0.041, 3e-4));
  CHECK_FALSE(flutter(times.head(8), positions.topRows(8)));
}

TEST_CASE("typical flutter refuses parts and times that would never end") {
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(40, 0.0, 1.3);
  const Eigen::MatrixX3d positions = Eigen::MatrixX3d::Random(40, 3);
  for (const double part : {0.0, -1.0, std::nan("")})
    CHECK_THROWS_WITH(typical_flutter(times, positions, part), Catch::Matchers::Contains("part [s] is "));
  CHECK_THROWS_AS(typical_flutter(times.reverse(), positions, 1.0), samara::ArgumentError);
  Eigen::VectorXd unknown = times;
  unknown[20] = std::nan("");
  CHECK_THROWS_WITH(typical_flutter(unknown, positions, 1.0),
                    Catch::Matchers::Contains("the time of frame 20 is not finite"));
  // Shorter than the last digit of a time: a frame each.
  CHECK_FALSE(typical_flutter(times, positions, 1e-300));
}
