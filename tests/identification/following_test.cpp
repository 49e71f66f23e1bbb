#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>

#include "../allocation_count.h"
#include "../error_text.h"
#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/identification/following/follow_report.h"
#include "samara/identification/following/followed_motion.h"
#include "samara/identification/following/follower.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara;
using namespace samara::identification;

namespace {

constexpr double kNotSeen = std::numeric_limits<double>::quiet_NaN();

/// A plate in air: chord 7 cm, 1 mm thick.
const std::map<std::string, double> kPlate = {{"semi_chord", 0.035},
                                              {"semi_thickness", 5e-4},
                                              {"density", 1200.0},
                                              {"fluid_density", 1.2},
                                              {"A", 1.4},
                                              {"B", 1.0},
                                              {"mu1", 0.2},
                                              {"mu2", 0.2}};
constexpr double kFrame = 0.01;

/// States of the plate at frames.
Eigen::MatrixXd plate_fall(const std::map<std::string, double>& start, double lift, int frames) {
  std::map<std::string, double> values = kPlate;
  values.insert({{"C_T", lift}, {"C_R", 1.5}});
  values.insert(start.begin(), start.end());
  const models::ParametricModel model(models::find_model("falling_plate"), values, {});
  std::vector<double> times;
  for (int k = 0; k < frames; ++k) times.push_back(kFrame * k);
  return models::integrate(model, {}, times).states;
}

/// What a camera sees: of x, y and theta, those with a noise.
struct PlateNoise {
  double place = 1e-3;  ///< m
  double angle = 0.02;  ///< rad; 0: not seen
};

FollowOptions plate_options(PlateNoise noise) {
  FollowOptions options;
  options.noise = {{"x", noise.place}, {"y", noise.place}};
  if (noise.angle > 0.0) options.noise["theta"] = noise.angle;
  options.fixed = kPlate;
  options.fixed["C_R"] = 1.5;
  options.coefficients = {
      {.name = "C_T", .value = 1.2, .deviation = 0.1, .logarithmic = true, .lower = 0.1, .upper = 5.0}};
  options.start = {{"vx", {0.0, 1.0}}, {"vy", {0.0, 1.0}}, {"w", {0.0, 8.0}}};
  if (noise.angle == 0.0) options.start["theta"] = {0.0, 1.9};
  return options;
}

/// In the order of Follower::measured(): by name.
std::vector<double> seen_of(const Follower& follower, const models::ModelInfo& info,
                            const Eigen::RowVectorXd& state, const FollowOptions& options, Stream& random) {
  std::vector<double> values;
  for (const std::string& name : follower.measured()) {
    for (std::size_t i = 0; i < info.states.size(); ++i) {
      if (info.states[i].name == name)
        values.push_back(state[static_cast<Eigen::Index>(i)] + options.noise.at(name) * random.normal());
    }
  }
  return values;
}

}  // namespace

TEST_CASE("innovations and errors of followed plates have the distributions that the follower gives them") {
  // Each fall has a lift of its own, drawn from what is known of it beforehand.
  const auto model = models::find_model("falling_plate");
  const FollowOptions options = plate_options({});
  constexpr int kFalls = 40, kFrames = 40, kAhead = 10;
  double innovations = 0.0, errors = 0.0;
  int compared = 0, inside = 0, forecasts = 0;
  for (int fall = 0; fall < kFalls; ++fall) {
    Stream random(7, static_cast<std::uint64_t>(fall));
    const double lift = 1.2 * std::exp(0.1 * random.normal());
    const Eigen::MatrixXd truth = plate_fall({{"vx(0)", 0.5 * random.normal()},
                                              {"vy(0)", 0.5 * random.normal()},
                                              {"w(0)", 4.0 * random.normal()},
                                              {"theta(0)", std::numbers::pi * random.uniform()}},
                                             lift, kFrames + kAhead);
    Follower follower(model, options);
    std::vector<double> later;
    for (int k = 0; k < kFrames + kAhead; ++k) {
      const std::vector<double> values = seen_of(follower, model->info(), truth.row(k), options, random);
      if (k >= kFrames) {
        later = values;
        continue;
      }
      const FollowedFrame frame = follower.add(kFrame * k, values);
      if (std::isnan(frame.innovation_squared)) continue;
      innovations += frame.innovation_squared;
      compared += frame.values;
    }
    const FollowedState state = follower.state();
    Eigen::VectorXd error(7);
    error << (state.states - truth.row(kFrames - 1).transpose()), std::log(state.coefficients[0] / lift);
    errors += error.dot(state.covariance.ldlt().solve(error));
    const Forecast ahead = follower.forecast(std::array{kFrame * (kFrames + kAhead - 1)});
    for (Eigen::Index o = 0; o < 3; ++o) {
      const ForecastComponent& most = ahead.components.front();
      const double miss = later[static_cast<std::size_t>(o)] - most.mean(0, o);
      if (std::abs(miss) < 1.645 * std::sqrt(most.covariance[0](o, o))) ++inside;
      ++forecasts;
    }
  }
  // chi^2 with n degrees of freedom: mean n, deviation sqrt(2 n); within 3.5 deviations.
  CHECK(std::abs(innovations - compared) < 3.5 * std::sqrt(2.0 * compared));
  constexpr double kErrors = 7.0 * kFalls;
  CHECK(std::abs(errors - kErrors) < 3.5 * std::sqrt(2.0 * kErrors));
  // 90 % of 120 that are not independent: within 3 times sqrt(3) binomial deviations.
  CHECK(std::abs(inside - 0.9 * forecasts) < 3.0 * std::sqrt(3.0 * 0.09 * forecasts));
}

TEST_CASE("frames after the origin of a forecast do not change a bit of it") {
  const auto model = models::find_model("falling_plate");
  const FollowOptions options = plate_options({.angle = 0.0});
  const Eigen::MatrixXd truth = plate_fall({{"w(0)", 3.0}, {"theta(0)", 0.7}}, 1.3, 40);
  constexpr int kOrigin = 25;
  std::vector<Forecast> forecasts;
  for (const double altered : {0.0, 0.05, kNotSeen}) {
    Stream random(3, 0);
    Follower follower(model, options);
    for (int k = 0; k < 40; ++k) {
      std::vector<double> values = seen_of(follower, model->info(), truth.row(k), options, random);
      if (k > kOrigin) values[0] += altered;
      follower.add(kFrame * k, values);
      if (k == kOrigin)
        forecasts.push_back(follower.forecast(std::array{kFrame * (k + 5), kFrame * (k + 10)}));
    }
  }
  for (const Forecast& other : forecasts) {
    REQUIRE(other.components.size() == forecasts[0].components.size());
    for (std::size_t c = 0; c < other.components.size(); ++c) {
      CHECK(other.components[c].weight == forecasts[0].components[c].weight);
      CHECK(other.components[c].mean == forecasts[0].components[c].mean);
      CHECK(other.components[c].covariance == forecasts[0].components[c].covariance);
    }
  }
}

TEST_CASE("an angle that no frame shows is found from the places, up to the half turn that changes nothing") {
  const auto model = models::find_model("falling_plate");
  const FollowOptions options = plate_options({.place = 5e-4, .angle = 0.0});
  int lost = 0;
  for (int fall = 0; fall < 6; ++fall) {
    Stream random(5, static_cast<std::uint64_t>(fall));
    const double theta = std::numbers::pi * (random.uniform() - 0.5);
    const Eigen::MatrixXd truth =
        plate_fall({{"vx(0)", 0.3}, {"w(0)", 5.0 * random.normal()}, {"theta(0)", theta}}, 1.2, 60);
    Follower follower(model, options);
    int most = 0;
    for (int k = 0; k < 60; ++k) {
      const FollowedFrame frame =
          follower.add(kFrame * k, seen_of(follower, model->info(), truth.row(k), options, random));
      most = std::max(most, frame.hypotheses);
    }
    CAPTURE(fall, theta);
    CHECK(most > 1);
    if (!follower.is_following()) {
      ++lost;  // and says so
      continue;
    }
    const FollowedState state = follower.state();
    const double error = std::remainder(state.states[3] - truth(59, 3), std::numbers::pi);
    CHECK(std::abs(error) < 4.0 * std::sqrt(state.covariance(3, 3)));
    CHECK(std::sqrt(state.covariance(3, 3)) < 0.3);
  }
  CHECK(lost <= 1);
}

TEST_CASE("a fall that is lost is found again, and hardly any is lost where the model may be off a little") {
  // Of starts that places alone show, a normal distribution is too sure: a filter whose model knows
  // no noise cannot leave a wrong angle.
  const auto model = models::find_model("falling_plate");
  FollowOptions options = plate_options({.place = 5e-4, .angle = 0.0});
  constexpr int kFrames = 60;
  const auto lost_with = [&](const ModelNoise& noise) {
    options.model_noise = noise;
    int lost = 0;
    for (int fall = 0; fall < 12; ++fall) {
      Stream random(5, static_cast<std::uint64_t>(fall));
      const double theta = std::numbers::pi * (random.uniform() - 0.5);
      const Eigen::MatrixXd truth =
          plate_fall({{"vx(0)", 0.3}, {"w(0)", 5.0 * random.normal()}, {"theta(0)", theta}}, 1.2, kFrames);
      Follower follower(model, options);
      int since = kFrames;
      for (int k = 0; k < kFrames; ++k) {
        const FollowedFrame frame =
            follower.add(kFrame * k, seen_of(follower, model->info(), truth.row(k), options, random));
        ++since;
        if (frame.status != FollowStatus::lost) continue;
        ++lost;
        since = 0;
      }
      CAPTURE(fall, since);
      CHECK(follower.is_following() == (since >= options.start_frames));
      if (!follower.is_following() || noise.velocity == 0.0) continue;
      const FollowedState state = follower.state();
      const double error = std::remainder(state.states[3] - truth(kFrames - 1, 3), std::numbers::pi);
      CHECK(std::abs(error) < 4.0 * std::sqrt(state.covariance(3, 3)));
    }
    return lost;
  };
  CHECK(lost_with({}) > 3);
  CHECK(lost_with({.velocity = 0.1, .rate = 1.0}) <= 1);
}

TEST_CASE("a coefficient that drifts is followed, within its errors") {
  const auto model = models::find_model("falling_plate");
  FollowOptions options = plate_options({.place = 2e-4, .angle = 5e-3});
  options.coefficients[0].drift = 0.5;
  Eigen::MatrixXd first = plate_fall({{"w(0)", 1.0}, {"theta(0)", 0.3}}, 1.2, 60);
  std::map<std::string, double> next;
  for (Eigen::Index i = 0; i < 6; ++i)
    next[model->info().states[static_cast<std::size_t>(i)].name + "(0)"] = first(59, i);
  const Eigen::MatrixXd second = plate_fall(next, 2.0, 80);  // the lift has jumped
  Follower follower(model, options);
  Stream random(11, 0);
  for (int k = 0; k < 60; ++k)
    follower.add(kFrame * k, seen_of(follower, model->info(), first.row(k), options, random));
  const double before = follower.state().coefficients[0];
  for (int k = 1; k < 80; ++k)
    follower.add(kFrame * (59 + k), seen_of(follower, model->info(), second.row(k), options, random));
  const FollowedState state = follower.state();
  CHECK(before == Approx(1.2).epsilon(0.15));
  CHECK(state.coefficients[0] == Approx(2.0).epsilon(0.1));
  CHECK(std::abs(std::log(state.coefficients[0] / 2.0)) < 3.0 * std::sqrt(state.covariance(6, 6)));
}

TEST_CASE("an attitude stays a unit quaternion and is found from places alone, or from itself") {
  // A disc of 5 cm, seen from one of its flutters.
  const auto model = models::find_model("immersed_body");
  const std::map<std::string, double> disc = {
      {"a", 0.05},   {"b", 0.05},    {"c", 1e-3},  {"density", 100.0}, {"fluid_density", 1.2},
      {"C_D0", 0.1}, {"C_D90", 2.0}, {"C_T", 1.0}, {"C_R", 1.0},       {"C_w", 3.0}};
  std::map<std::string, double> values = disc;
  const double half = 0.35;
  values.insert({{"qw(0)", std::cos(half)},
                 {"qx(0)", std::sin(half) * 0.8},
                 {"qy(0)", std::sin(half) * 0.6},
                 {"wx(0)", 1.0},
                 {"wy(0)", -0.5}});
  std::vector<double> times;
  for (int k = 0; k < 60; ++k) times.push_back(kFrame * k);
  const Eigen::MatrixXd truth =
      models::integrate(models::ParametricModel(model, values, {}), {}, times).states;
  const auto index = [&](const std::string& name) {
    const auto& states = model->info().states;
    return std::ranges::find(states, name, &models::StateInfo::name) - states.begin();
  };
  for (const bool is_seen : {false, true}) {
    FollowOptions options;
    options.fixed = disc;
    options.fixed["wz(0)"] = 0.0;
    options.round_body = true;
    for (const char* place : {"x", "y", "z"}) options.noise[place] = 2e-4;
    for (const char* velocity : {"ux", "uy", "uz"}) options.start[velocity] = {0.0, 2.0};
    for (const char* rate : {"wx", "wy"}) options.start[rate] = {0.0, 5.0};
    if (is_seen) options.attitude_noise = 0.02;
    options.start_frames = 12;
    Follower follower(model, options);
    Stream random(2, 0);
    for (Eigen::Index k = 0; k < truth.rows(); ++k) {
      std::vector<double> seen;
      for (const char* place : {"x", "y", "z"})
        seen.push_back(truth(k, index(place)) + 2e-4 * random.normal());
      if (is_seen) {
        for (const char* part : {"qw", "qx", "qy", "qz"})
          seen.push_back(-truth(k, index(part)));  // the same attitude
      }
      follower.add(times[static_cast<std::size_t>(k)], seen);
    }
    const FollowedState state = follower.state();
    const Eigen::Vector4d q = state.states.segment<4>(index("qw")),
                          exact = truth.row(59).segment<4>(index("qw"));
    CHECK(std::abs(q.norm() - 1.0) < 1e-12);
    const auto normal = [](const Eigen::Vector4d& p) {
      return Eigen::Vector3d(2 * (p[1] * p[3] + p[0] * p[2]), 2 * (p[2] * p[3] - p[0] * p[1]),
                             1 - 2 * (p[1] * p[1] + p[2] * p[2]));
    };
    // Over, or not: a disc.
    CHECK(std::abs(normal(q).dot(normal(exact.normalized()))) > std::cos(0.1));
  }
}

TEST_CASE("errors about an attitude that an update turned far are those of the frame that showed it") {
  constexpr double kTurnNoise = 1e-3;  // rad
  FollowOptions options;
  options.fixed = {{"a", 0.05},   {"b", 0.05},    {"c", 1e-3},  {"density", 100.0}, {"fluid_density", 1.2},
                   {"C_D0", 0.1}, {"C_D90", 2.0}, {"C_T", 1.0}, {"C_R", 1.0},       {"C_w", 3.0}};
  for (const char* place : {"x", "y", "z"}) options.noise[place] = 1e-3;
  for (const char* velocity : {"ux", "uy", "uz"}) options.start[velocity] = {0.0, 0.1};
  // After a frame the attitude is known to a radian: the next one says all.
  for (const char* rate : {"wx", "wy", "wz"}) options.start[rate] = {0.0, 100.0};
  options.attitude_noise = kTurnNoise;
  options.start_frames = 1;
  Follower follower(models::find_model("immersed_body"), options);
  const double half = 0.5;
  follower.add(0.0, std::vector<double>{0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0});
  follower.add(kFrame, std::vector<double>{0.0, 0.0, 0.0, std::cos(half), 0.6 * std::sin(half), 0.0,
                                           0.8 * std::sin(half)});
  const auto& names = follower.error_names();
  const auto at = std::ranges::find(names, "turn about x") - names.begin();
  REQUIRE(at + 3 <= std::ssize(names));
  const Eigen::Matrix3d errors = follower.state().covariance.block<3, 3>(at, at) / (kTurnNoise * kTurnNoise);
  CAPTURE(errors);
  CHECK((errors - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 0.01);
}

TEST_CASE("a follower passes over frames that are blind and far off, and says so") {
  const auto model = models::find_model("falling_plate");
  const FollowOptions options = plate_options({});
  const Eigen::MatrixXd truth = plate_fall({{"w(0)", 3.0}, {"theta(0)", 0.7}}, 1.2, 60);
  Stream random(3, 0);
  Follower follower(model, options);
  for (int k = 0; k < 60; ++k) {
    std::vector<double> values = seen_of(follower, model->info(), truth.row(k), options, random);
    if (k == 30 || k == 41) values[1] += 0.3;
    if (k == 35) values.assign(3, kNotSeen);
    const FollowStatus status = follower.add(kFrame * k, values).status;
    CAPTURE(k);
    CHECK(status == (k < 7                ? FollowStatus::starting
                     : k == 30 || k == 41 ? FollowStatus::outlier
                     : k == 35            ? FollowStatus::blind
                                          : FollowStatus::following));
  }
  CHECK(std::abs(follower.state().states[5] - truth(59, 5)) < 3e-3);

  SECTION("a motion that is no longer there is lost, and found again where it is") {
    int lost = 0;
    for (int k = 60; k < 90; ++k) {
      std::vector<double> values = seen_of(follower, model->info(), truth.row(k - 60), options, random);
      if (follower.add(kFrame * k, values).status == FollowStatus::lost) ++lost;
    }
    CHECK(lost == 1);
    REQUIRE(follower.is_following());
    CHECK(std::abs(follower.state().states[5] - truth(29, 5)) < 3e-3);
  }
}

TEST_CASE("a follower does not allocate from frame to frame") {
  const auto model = models::find_model("falling_plate");
  const FollowOptions options = plate_options({});
  const Eigen::MatrixXd truth = plate_fall({{"w(0)", 3.0}, {"theta(0)", 0.7}}, 1.2, 40);
  Stream random(3, 0);
  Follower follower(model, options);
  for (int k = 0; k < 40; ++k) {
    const std::vector<double> values = seen_of(follower, model->info(), truth.row(k), options, random);
    const long calls = allocation_counter::during([&] { follower.add(kFrame * k, values); });
    if (k > 12) CHECK(calls == 0);
  }
}

TEST_CASE("a delay or a gain that a fit holds is refused, but for one that changes nothing") {
  const auto model = models::find_model("vertical_fall");
  FitResult fitted{.status = Termination::converged, .model = "vertical_fall"};
  fitted.setup.compared.outputs = {"x"};
  fitted.noise = {{.outputs = {"x"}, .unit = "m", .value = 1e-3}};
  Capture capture{.id = "drop", .file = {}, .labels = {{"late", "0.02"}}, .times = {}, .channels = {}};
  capture.times = Eigen::Vector3d(0.0, 0.1, 0.2);
  capture.channels = {{"x", "m", Eigen::Vector3d::Zero()}};
  const auto refusal = [&] {
    return error_text<ArgumentError>([&] { follow_options(*model, fitted, capture); });
  };
  fitted.fixed["gain of x"] = 1.1;
  CHECK_THAT(refusal(), Catch::Contains("holds \"gain of x\" at 1.1; 1 was expected"));
  fitted.fixed = {{"gain of x", 1.0}, {"delay", 0.0}};
  CHECK_FALSE(follow_options(*model, fitted, capture).fixed.contains("delay"));
  fitted.setup.unknowns.fixed["delay"] = 0.05;
  CHECK_THAT(refusal(), Catch::Contains("holds \"delay\" at 0.05; 0 was expected"));
  fitted.setup.unknowns.fixed.clear();
  fitted.setup.unknowns.known["delay"] = "late";
  CHECK_THAT(refusal(), Catch::Contains("holds \"delay\" at 0.02"));
  capture.labels["late"] = "0";
  CHECK_FALSE(follow_options(*model, fitted, capture).fixed.contains("delay"));
}

TEST_CASE(
    "an attitude of which a part is missing counts as not seen, and one of no length is the file's fault") {
  const auto model = models::find_model("immersed_body");
  FollowOptions options;
  options.fixed = {{"a", 0.05},   {"b", 0.05},    {"c", 1e-3},  {"density", 100.0}, {"fluid_density", 1.2},
                   {"C_D0", 0.1}, {"C_D90", 2.0}, {"C_T", 1.0}, {"C_R", 1.0},       {"C_w", 3.0}};
  options.noise = {{"x", 1e-3}};
  options.attitude_noise = 0.02;
  Follower follower(model, options);
  Capture capture{.id = "disc", .file = "disc.csv", .labels = {}, .times = {}, .channels = {}};
  capture.times = Eigen::Vector3d(0.0, 0.1, 0.2);
  capture.channels = {{"x", "m", Eigen::Vector3d::Zero()}, {"qw", "1", Eigen::Vector3d(1.0, 1.0, 0.0)}};
  for (const char* part : {"qx", "qy", "qz"})
    capture.channels.push_back({part, "1", Eigen::Vector3d::Zero()});
  capture.channels.back().values[1] = kNotSeen;
  const Eigen::MatrixXd values = frames_of(follower, model->info(), capture);
  CHECK(values.row(0).tail(4).allFinite());
  CHECK(values.row(1).tail(4).array().isNaN().all());
  CHECK(values(1, 0) == 0.0);
  add_frame(follower, capture, values, 0);
  add_frame(follower, capture, values, 1);
  CHECK_THAT(error_text<InputError>([&] { add_frame(follower, capture, values, 2); }),
             Catch::Contains("disc.csv: capture \"disc\": the attitude at 0.2 s has the length 0"));
}

TEST_CASE("a name that is no UTF-8 does not keep the JSON of a followed motion from being written") {
  FollowReport report;
  report.motion.capture = "not \xff utf-8";
  CHECK_THAT(follow_json(report), Catch::Contains("\"capture\":\"not \xef\xbf\xbd utf-8\""));
}

TEST_CASE("warnings of a followed motion are told once each, and stand in its JSON as sentences") {
  FollowReport report;
  CHECK(report.warnings.add(WarningKind::source, "the camera is not known"));
  CHECK_FALSE(report.warnings.add(WarningKind::source, "the camera is not known"));
  CHECK_THAT(follow_json(report), Catch::Contains("\"warnings\":[\"the camera is not known\"]"));
}

TEST_CASE("a motion lost before its last frame is not followed to its end, and a warning says so") {
  FollowReport report;
  FollowedMotion& motion = report.motion;
  motion.times = Eigen::Vector4d(0.0, 0.1, 0.2, 0.3);
  motion.state_times = motion.times;
  motion.values = Eigen::Vector4d(1.0, 1.0, kNotSeen, kNotSeen);
  motion.frames.resize(4, {.status = FollowStatus::following, .values = 1});
  motion.frames[2].status = motion.frames[3].status = FollowStatus::blind;
  FollowReport unseen = report;
  add_follow_warnings(unseen);
  CHECK(is_followed_to_end(unseen));
  CHECK(unseen.warnings.empty());

  motion.frames[2].status = FollowStatus::lost;
  add_follow_warnings(report);
  CHECK_FALSE(is_followed_to_end(report));
  CHECK(report.warnings.has(WarningKind::model, "lost after 0.1 s, and not found again"));
  CHECK(report.warnings.has(WarningKind::model, "the last frame, at 0.2 s"));
  CHECK(report.warnings.size() == 1);
}

TEST_CASE("many frames far from the forecast bring a warning, a motion lost once and found again does not") {
  FollowReport report;
  FollowedMotion& motion = report.motion;
  constexpr Eigen::Index kFrames = 30;
  motion.times = motion.state_times = Eigen::VectorXd::LinSpaced(kFrames, 0.0, 2.9);
  motion.values = Eigen::VectorXd::Ones(kFrames);
  motion.frames.resize(kFrames, {.status = FollowStatus::following, .values = 3, .innovation_squared = 6.0});
  for (std::size_t k = 0; k < 8; ++k)
    motion.frames[k] = {.status = k < 7 ? FollowStatus::starting : FollowStatus::following, .values = 3};
  const FollowedFrame far = {.status = FollowStatus::outlier, .values = 3, .innovation_squared = 500.0};
  const auto warned = [](FollowReport of) {
    add_follow_warnings(of);
    CHECK(is_followed_to_end(of));
    return !of.warnings.empty();
  };
  CHECK_FALSE(warned(report));

  FollowReport lost_once = report;
  for (std::size_t k = 10; k < 16; ++k) lost_once.motion.frames[k] = far;
  lost_once.motion.frames[15].status = FollowStatus::lost;
  CHECK_FALSE(warned(lost_once));
  CHECK_THAT(follow_text(lost_once), Catch::Contains("are 2 times what was expected of 48 values"));
  // Lost a second time.
  FollowReport lost_again = lost_once;
  for (std::size_t k = 16; k < 22; ++k) lost_again.motion.frames[k] = lost_once.motion.frames[k - 6];
  CHECK(warned(lost_again));

  // A tenth of the 22 frames that were compared is 2.2.
  for (const std::size_t k : {10U, 15U}) motion.frames[k] = far;
  CHECK_FALSE(warned(report));
  motion.frames[20] = far;
  CHECK(warned(report));
  add_follow_warnings(report);
  CHECK(report.warnings.has(
      WarningKind::model,
      "3 of 22 frames lie farther from the forecast than errors allow, where one in 10,000"));
  CHECK(report.warnings.size() == 1);

  // Nine frames tell too little.
  FollowReport few = report;
  for (std::size_t k = 17; k < 30; ++k) few.motion.frames[k] = {.status = FollowStatus::blind};
  few.warnings = {};
  CHECK_FALSE(warned(few));
}
