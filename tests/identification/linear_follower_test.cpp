#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/identification/following/follower.h"
#include "samara/identification/following/noise_search.h"
#include "samara/models/equations/equation_model.h"

using namespace samara;
using namespace samara::identification;

namespace {

constexpr double kBlind = std::numeric_limits<double>::quiet_NaN();

/// Falling with a drag linear in speed is left out: x' = v, v' = -g, linear, so that the filter of Kalman is exact.
std::shared_ptr<const models::Model> falling_point() {
  return models::equation_model({.name = "falling_point",
                                 .states = {{.name = "x", .unit = "m"}, {.name = "v", .unit = "m/s"}},
                                 .parameters = {{.name = "g", .unit = "m/s^2"}},
                                 .rates = {"v", "-g"}});
}

constexpr double kPlaceNoise = 2e-3;     // m
constexpr double kVelocityNoise = 0.05;  // m/s per sqrt(s)

FollowOptions point_options() {
  FollowOptions options;
  options.noise = {{"x", kPlaceNoise}};
  options.coefficients = {{.name = "g", .value = 9.0, .deviation = 0.5}};
  options.start = {{"x", {1.0, 0.1}}, {"v", {0.3, 0.4}}};
  options.model_noise.velocity = kVelocityNoise;
  options.start_frames = 1;
  options.remember = true;
  return options;
}

/// Frames at uneven times, one without a value.
struct PointFrames {
  std::vector<double> times, values;
};
PointFrames point_frames() {
  Stream random(1, 0);
  PointFrames frames;
  for (int k = 0; k < 25; ++k) {
    const double t = 0.01 * k + (k % 3 == 1 ? 0.004 : 0.0);
    frames.times.push_back(t);
    frames.values.push_back(k == 12 ? kBlind
                                    : 1.02 + 0.5 * t - 0.5 * 9.81 * t * t + kPlaceNoise * random.normal());
  }
  return frames;
}

/// All states of all frames at once: mean and covariance of (x, v) of each frame and g, by least squares with the exact
/// covariance of a double integrator's noise. Only the first `seen` frames count.
struct BatchSolution {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};
BatchSolution batch_solution(const PointFrames& frames, std::size_t count, std::size_t seen) {
  const auto size = static_cast<Eigen::Index>(2 * count + 1);
  const Eigen::Index g = size - 1;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  const auto add = [&](const Eigen::MatrixXd& rows, const Eigen::VectorXd& value,
                       const Eigen::MatrixXd& covariance) {
    const Eigen::MatrixXd weighted = covariance.inverse() * rows;
    normal += rows.transpose() * weighted;
    right += weighted.transpose() * value;
  };
  const auto one = [&](Eigen::Index unknown, double value, double deviation) {
    Eigen::MatrixXd row = Eigen::MatrixXd::Zero(1, size);
    row(0, unknown) = 1.0;
    add(row, Eigen::VectorXd::Constant(1, value), Eigen::MatrixXd::Constant(1, 1, deviation * deviation));
  };
  one(0, 1.0, 0.1);
  one(1, 0.3, 0.4);
  one(g, 9.0, 0.5);
  for (std::size_t k = 0; k < count; ++k) {
    const auto at = static_cast<Eigen::Index>(2 * k);
    if (k < seen && !std::isnan(frames.values[k])) one(at, frames.values[k], kPlaceNoise);
    if (k + 1 == count) continue;
    const double h = frames.times[k + 1] - frames.times[k];
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2, size);
    rows.block<2, 2>(0, at + 2).setIdentity();
    rows.block<2, 2>(0, at) << -1.0, -h, 0.0, -1.0;
    rows(0, g) = 0.5 * h * h;
    rows(1, g) = h;
    Eigen::Matrix2d noise;
    noise << h * h * h / 3.0, h * h / 2.0, h * h / 2.0, h;
    add(rows, Eigen::Vector2d::Zero(), kVelocityNoise * kVelocityNoise * noise);
  }
  const Eigen::MatrixXd covariance = normal.inverse();
  return {covariance * right, covariance};
}

void check_equal(const FollowedState& state, const BatchSolution& exact, std::size_t frame) {
  const Eigen::Index at = static_cast<Eigen::Index>(2 * frame), g = exact.mean.size() - 1;
  const std::vector<Eigen::Index> own = {at, at + 1, g};
  // Round-off: covariances of places are of 1e-6 m^2, of g of 0.25.
  CHECK(state.states[0] == Approx(exact.mean[at]).epsilon(1e-8).margin(1e-8));
  CHECK(state.states[1] == Approx(exact.mean[at + 1]).epsilon(1e-8).margin(1e-8));
  CHECK(state.coefficients[0] == Approx(exact.mean[g]).epsilon(1e-8));
  const Eigen::MatrixXd expected = exact.covariance(own, own);
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) {
      const double size = std::sqrt(expected(i, i) * expected(j, j));
      CHECK(std::abs(state.covariance(i, j) - expected(i, j)) < 1e-6 * size);
    }
  }
}

}  // namespace

TEST_CASE("of a linear motion a follower says what least squares over all frames so far say") {
  const PointFrames frames = point_frames();
  Follower follower(falling_point(), point_options());
  for (std::size_t k = 0; k < frames.times.size(); ++k) {
    follower.add(frames.times[k], std::array{frames.values[k]});
    check_equal(follower.state(), batch_solution(frames, k + 1, k + 1), k);
  }
  const std::vector<FollowedState> smoothed = follower.smoothed();
  REQUIRE(smoothed.size() == frames.times.size());
  const BatchSolution all = batch_solution(frames, frames.times.size(), frames.times.size());
  for (std::size_t k = 0; k < smoothed.size(); ++k) check_equal(smoothed[k], all, k);
}

TEST_CASE("a forecast of a linear motion has the mean and the variance of a frame ahead") {
  PointFrames frames = point_frames();
  Follower follower(falling_point(), point_options());
  constexpr std::size_t kSeen = 15;
  for (std::size_t k = 0; k < kSeen; ++k) follower.add(frames.times[k], std::array{frames.values[k]});
  const std::vector<double> ahead(frames.times.begin() + kSeen - 1, frames.times.end());
  const Forecast forecast = follower.forecast(ahead);
  const BatchSolution exact = batch_solution(frames, frames.times.size(), kSeen);
  REQUIRE(forecast.components.size() == 1);
  CHECK(forecast.outputs == std::vector<std::string>{"x"});
  for (std::size_t k = 0; k < ahead.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(2 * (k + kSeen - 1));
    const auto row = static_cast<Eigen::Index>(k);
    CHECK(forecast.components[0].mean(row, 0) == Approx(exact.mean[at]).epsilon(1e-9));
    CHECK(forecast.components[0].covariance[k](0, 0) ==
          Approx(exact.covariance(at, at) + kPlaceNoise * kPlaceNoise).epsilon(1e-6));
  }
}

TEST_CASE("a follower refuses frames that cannot be, and stays where it was") {
  Follower follower(falling_point(), point_options());
  follower.add(0.0, std::array{1.0});
  follower.add(0.1, std::array{1.0});
  const FollowedState before = follower.state();
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(follower.add(0.1, std::array{1.0}), Catch::Contains("later one was expected"));
  CHECK_THROWS_WITH(follower.add(0.05, std::array{1.0}), Catch::Contains("follows one at 0.1 s"));
  CHECK_THROWS_AS(follower.add(kBlind, std::array{1.0}), ArgumentError);
  CHECK_THROWS_WITH(follower.add(0.2, std::array{infinity}), Catch::Contains("infinite"));
  CHECK_THROWS_WITH(follower.add(0.2, std::array{1.0, 2.0}), Catch::Contains("1 were expected"));
  CHECK(follower.state().states == before.states);
  CHECK_THROWS_WITH(follower.forecast(std::array{0.05}), Catch::Contains("not earlier"));
  FollowOptions options = point_options();
  options.noise = {{"y", 1.0}};
  CHECK_THROWS_WITH(Follower(falling_point(), options), Catch::Contains("no output \"y\""));
  options = point_options();
  options.noise["x"] = 0.0;
  CHECK_THROWS_WITH(Follower(falling_point(), options), Catch::Contains("noise of x"));
}

TEST_CASE("a start that is held is that of the first frame, not of the frames after a loss") {
  constexpr double kSpeedNoise = 0.01;  // m/s
  FollowOptions options;
  options.noise = {{"x", kPlaceNoise}, {"v", kSpeedNoise}};
  options.fixed = {{"g", 9.81}, {"v(0)", 0.5}};
  options.model_noise.velocity = kVelocityNoise;
  Follower follower(falling_point(), options);
  Stream random(2, 0);
  int lost = 0;
  double v = 0.0;
  for (int k = 0; k < 60; ++k) {
    const double t = 0.01 * k, spoilt = k >= 30 && k < 36 ? 5.0 : 0.0;
    v = 0.5 - 9.81 * t;
    const std::array values = {1.0 + 0.5 * t - 0.5 * 9.81 * t * t + spoilt + kPlaceNoise * random.normal(),
                               v + spoilt + kSpeedNoise * random.normal()};
    // Measured values come by name: v, then x.
    if (follower.add(t, std::array{values[1], values[0]}).status == FollowStatus::lost) ++lost;
  }
  CHECK(lost == 1);
  REQUIRE(follower.is_following());
  // A frame's noise, which the frames before make less.
  CHECK(follower.state().states[1] == Approx(v).margin(4.0 * kSpeedNoise));
}

TEST_CASE("a motion that breaks down before a frame counts as the least likely, not as sure") {
  // x = 1/(1 - t): there is none at 3 s.
  const auto model = models::equation_model({.name = "pole",
                                             .states = {{.name = "x", .unit = "1"}},
                                             .parameters = {{.name = "k", .unit = "s^-1"}},
                                             .rates = {"k*x*x"}});
  FollowOptions options;
  options.noise = {{"x", 1e-2}};
  options.fixed = {{"k", 1.0}};
  options.start_frames = 1;
  const auto scored = [&](Eigen::Index frames) {
    Capture capture{.id = "pole", .file = {}, .labels = {}, .times = {}, .channels = {}};
    capture.times = Eigen::Vector4d(0.0, 0.1, 0.2, 3.0).head(frames);
    capture.channels = {{"x", "1", Eigen::Vector4d(1.0, 1.0 / 0.9, 1.25, 1.0).head(frames)}};
    const NoiseChoice exact{.velocity = 0.0, .rate = 0.0, .spread = 0.0, .drift = 0.0};
    const NoiseChoice said = score_of(model, std::array{options}, std::array{capture}, {}, exact);
    return std::pair(said.frames, said.frames * said.score);
  };
  const auto [sound_frames, sound] = scored(3);
  const auto [all_frames, all] = scored(4);
  CHECK(all_frames == sound_frames + 1);
  CHECK(all == Approx(sound - 50.0));
}
