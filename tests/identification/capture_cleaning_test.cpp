#include "samara/identification/captures/capture_cleaning.h"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "files.h"
#include "samara/identification/captures/frame_grid.h"
#include "samara/identification/captures/impact.h"

using namespace samara::identification;
using Eigen::Index;

namespace {

Capture capture_of(const Eigen::VectorXd& times, const std::vector<Channel>& channels) {
  Capture capture;
  capture.id = "ball";
  capture.times = times;
  capture.channels = channels;
  return capture;
}

/// Frame numbers of `count` frames of which some were dropped.
std::vector<int> numbers_with_drops(int count, std::mt19937_64& random) {
  std::vector<int> numbers = {0};
  while (static_cast<int>(numbers.size()) < count) {
    numbers.push_back(numbers.back() + (random() % 10 == 0 ? 2 + static_cast<int>(random() % 3) : 1));
  }
  return numbers;
}

}  // namespace

TEST_CASE("rounded times go back to the grid they came from") {
  // 6.933 ms, rounded to ms: the median interval is 1 % off, so that plain counting goes wrong after 50
  // frames.
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937_64 random(seed);
    const double period = 6.933e-3;
    const std::vector<int> numbers = numbers_with_drops(150, random);
    Eigen::VectorXd times(150);
    for (Index k = 0; k < 150; ++k)
      times[k] = std::round(1e3 * (0.0021 + period * numbers[static_cast<std::size_t>(k)])) / 1e3;
    const FrameGrid grid = on_frame_grid(capture_of(times, {{"x", "m", times}}));
    for (Index k = 0; k < 150; ++k) {
      const double place = (grid.capture.times[k] - grid.capture.times[0]) / grid.period;
      CHECK(std::lround(place) == numbers[static_cast<std::size_t>(k)]);
    }
    // Rounding has a standard deviation of 1/sqrt(12) ms, a slope through n of them sqrt(12)/n^1.5 of that.
    CHECK(std::abs(grid.period - period) < 4.0 * 1e-3 * std::pow(150.0, -1.5));
    CHECK(std::abs(grid.rms_shift - 1e-3 / std::sqrt(12.0)) < 0.05e-3);
    CHECK(grid.dropped_frames == numbers.back() + 1 - 150);
    CHECK(grid.capture.notes.size() == 1);
  }
}

TEST_CASE("a frame period that is known is kept, and frames are counted by it") {
  const double period = 6.933e-3;
  double largest_fitted = 0.0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937_64 random(seed);
    const std::vector<int> numbers = numbers_with_drops(22, random);
    Eigen::VectorXd times(22);
    for (Index k = 0; k < 22; ++k)
      times[k] = std::round(1e3 * (0.0001 * seed + period * numbers[static_cast<std::size_t>(k)])) / 1e3;
    const Capture capture = capture_of(times, {{"x", "m", times}});
    const FrameGrid grid = on_frame_grid(capture, period);
    CHECK(grid.period == period);
    for (Index k = 0; k < 22; ++k) {
      CHECK(grid.capture.times[k] - times[0] ==
            Approx(period * numbers[static_cast<std::size_t>(k)]).margin(1e-12));
    }
    largest_fitted = std::max(largest_fitted, std::abs(on_frame_grid(capture).period - period));
  }
  // Rounding has a standard deviation of 1/sqrt(12) ms, a slope through 22 of them sqrt(12)/22^1.5 of that: 0.14 % of
  // the period. The largest of 20 is more.
  CHECK(largest_fitted > 1e-3 * std::pow(22.0, -1.5));
  const Capture capture = capture_of(Eigen::VectorXd::LinSpaced(9, 0.0, 0.8), {});
  // Longer than what lies between frames: places increase, and the whole clock would be stretched.
  for (const double wrong : {0.0, -0.1, double{NAN}, double{INFINITY}, 0.2, 0.12, 0.07, 0.1 / 5.5, 0.1 / 20.5,
                             100.0, 1e-4, 1e-300})
    CHECK_THROWS_AS(on_frame_grid(capture, wrong), samara::ArgumentError);
  // By a period of half as much every second frame is missing.
  CHECK(on_frame_grid(capture, 0.05).dropped_frames == 8);
}

TEST_CASE("half of the frames of a grid may be missing, one after the other") {
  Eigen::VectorXd times(7);
  times << 0.0, 0.1, 0.3, 0.4, 0.6, 0.7, 0.9;
  const FrameGrid grid = on_frame_grid(capture_of(times, {}));
  CHECK(grid.period == Approx(0.1).epsilon(1e-3));
  CHECK(grid.dropped_frames == 3);
}

TEST_CASE("times without an interval, or with a jump that no frames lie in, have no grid") {
  const Eigen::VectorXd even = Eigen::VectorXd::LinSpaced(9, 0.0, 0.8);
  Eigen::VectorXd jump = even, missing = even;
  jump[8] = 1e12;
  missing[3] = NAN;
  for (const std::optional<double> period : {std::optional<double>(), std::optional(0.1)}) {
    CHECK_THROWS_WITH(on_frame_grid(capture_of(jump, {}), period), Catch::Contains("without such a jump"));
    for (const Eigen::VectorXd& times : {missing, Eigen::VectorXd(Eigen::VectorXd::Zero(9))})
      CHECK_THROWS_WITH(on_frame_grid(capture_of(times, {}), period), Catch::Contains("times that increase"));
  }
}

TEST_CASE("a grid holds over a long recording") {
  const double period = 1.0 / 239.7;
  const Index count = 20000;
  Eigen::VectorXd times(count);
  for (Index k = 0; k < count; ++k) times[k] = std::round(1e3 * period * static_cast<double>(k)) / 1e3;
  const FrameGrid grid = on_frame_grid(capture_of(times, {{"x", "m", times}}));
  CHECK(grid.dropped_frames == 0);
  CHECK(std::abs(grid.period / period - 1.0) < 1e-7);
}

TEST_CASE("frames that arrive late keep their order on the grid") {
  Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(60, 0.0, 0.59);
  times[20] += 0.008;  // 0.208, just before frame 21: nearest to its place
  times[40] += 0.006;
  times[41] += 0.004;
  const FrameGrid grid = on_frame_grid(capture_of(times, {{"x", "m", times}}));
  const Eigen::VectorXd steps = (grid.capture.times.tail(59) - grid.capture.times.head(59)) / grid.period;
  CHECK((steps.array() - 1.0).abs().maxCoeff() < 1e-9);
  CHECK(grid.dropped_frames == 0);
  CHECK(std::abs(grid.largest_shift - 0.008) < 0.0005);
}

TEST_CASE("gaps are where frames, or a quantity, are missing") {
  Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(20, 0.0, 1.9);
  times.tail(10).array() += 0.3;
  Eigen::VectorXd x = times;
  x.segment(4, 2).setConstant(NAN);
  const Capture capture = capture_of(times, {{"x", "m", x}});
  const auto of_frames = gaps(capture);
  REQUIRE(of_frames.size() == 1);
  CHECK(std::abs(of_frames[0].begin - 0.9) < 1e-12);
  CHECK(std::abs(of_frames[0].end - 1.3) < 1e-12);
  CHECK(of_frames[0].missing == 3);
  const auto of_x = gaps(capture, "x");
  REQUIRE(of_x.size() == 2);
  CHECK(std::abs(of_x[0].begin - 0.3) < 1e-12);
  CHECK(of_x[0].missing == 2);
}

TEST_CASE("frames that came late are not missing, and those that are stay so") {
  // The first 22 frames of flight 258 of table-tennis-ball-spin: half of them came up to 4 ms late.
  const std::vector<double> times = {0,     0.007, 0.013, 0.021, 0.027, 0.034, 0.041, 0.048,
                                     0.058, 0.065, 0.073, 0.079, 0.086, 0.092, 0.101, 0.107,
                                     0.112, 0.118, 0.125, 0.132, 0.138, 0.145};
  const std::vector<double> x = {0.259, 0.25,  0.242, 0.235, 0.227, 0.22, 0.212, 0.206, 0.197, 0.191, 0.183,
                                 0.176, 0.168, 0.162, 0.155, 0.147, 0.14, 0.134, 0.126, 0.12,  0.112, 0.106};
  const std::vector<double> y = {0.72,   0.658,  0.596,  0.533,  0.471,  0.411,  0.352,  0.292,
                                 0.232,  0.175,  0.115,  0.059,  0.003,  -0.054, -0.112, -0.167,
                                 -0.223, -0.277, -0.332, -0.386, -0.438, -0.492};
  const std::vector<double> z = {0.391, 0.397, 0.403, 0.409, 0.414, 0.416, 0.417, 0.42,  0.421, 0.42,  0.421,
                                 0.418, 0.415, 0.413, 0.41,  0.405, 0.4,   0.394, 0.388, 0.381, 0.372, 0.365};
  const auto flight_without = [&](int lost) {
    std::vector<std::vector<double>> kept(4);
    for (std::size_t k = 0; k < times.size(); ++k) {
      if (static_cast<int>(k) == lost) continue;
      for (std::size_t c = 0; c < 4; ++c) kept[c].push_back((*std::array{&times, &x, &y, &z}[c])[k]);
    }
    const auto values = [&](std::size_t c) {
      return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(kept[c].data(), std::ssize(kept[c])));
    };
    return on_frame_grid(
        capture_of(values(0), {{"x", "m", values(1)}, {"y", "m", values(2)}, {"z", "m", values(3)}}));
  };
  CHECK(flight_without(-1).dropped_frames == 0);
  CHECK(flight_without(-1).period == Approx(6.93e-3).epsilon(0.02));
  for (const int lost : {4, 12, 17}) {
    const FrameGrid grid = flight_without(lost);
    CAPTURE(lost);
    CHECK(grid.dropped_frames == 1);
    const Eigen::VectorXd& on_grid = grid.capture.times;
    CHECK(on_grid[lost] - on_grid[lost - 1] == Approx(2.0 * grid.period));
  }
}

namespace {

/// Frames of a path, without some of them.
int dropped_of(const std::function<Eigen::Vector2d(double)>& path, int count, int first_lost, int lost) {
  constexpr double kPeriod = 0.01;
  const Index kept = count - lost;
  Eigen::VectorXd times(kept), x(kept), z(kept);
  for (Index k = 0; k < kept; ++k) {
    times[k] = kPeriod * static_cast<double>(k < first_lost ? k : k + lost);
    const Eigen::Vector2d at = path(times[k]);
    x[k] = at[0];
    z[k] = at[1];
  }
  return on_frame_grid(capture_of(times, {{"x", "m", x}, {"z", "m", z}})).dropped_frames;
}

}  // namespace

TEST_CASE("all frames after the first may be late, and the period is that of the frames in time") {
  for (const Index late_from : {1, 2, 20}) {
    Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(60, 0.0, 0.59);
    const Eigen::VectorXd x = 3.0 * times;
    times.tail(60 - late_from).array() += 0.01;
    CAPTURE(late_from);
    // After the second frame one step is too few to go by.
    const FrameGrid grid = on_frame_grid(capture_of(times, {{"x", "m", x}}));
    CHECK(grid.dropped_frames == (late_from == 2 ? 1 : 0));
    CHECK(grid.period == Approx(0.01).epsilon(1e-3));
  }
}

TEST_CASE("frames lost where a body turns, circles or bounces stay missing") {
  const auto thrown = [](double t) { return Eigen::Vector2d(0.0, 5.0 * t - 4.905 * t * t); };
  const auto circling = [](double t) { return Eigen::Vector2d(std::cos(10.0 * t), std::sin(10.0 * t)); };
  const auto dropped = [](double t) { return Eigen::Vector2d(0.0, 4.0 * std::abs(t - 0.3)); };
  const auto bouncing = [](double t) { return Eigen::Vector2d(2.0 * t, 4.0 * std::abs(t - 0.3)); };
  for (int lost = 1; lost <= 20; ++lost) {
    CAPTURE(lost);
    CHECK(dropped_of(thrown, 100, 51 - lost / 2, lost) == lost);
    CHECK(dropped_of(circling, 100, 40, lost) == lost);
    // Wherever the bounce is between the frames that are left, the last or the first among them.
    for (int ahead = 1; ahead < lost + 1; ++ahead) {
      CHECK(dropped_of(dropped, 60, 31 - ahead, lost) == lost);
      CHECK(dropped_of(bouncing, 60, 31 - ahead, lost) == lost);
    }
    const auto off_grid = [&](double t) { return dropped(t + 0.005); };
    CHECK(dropped_of(off_grid, 60, 30 - lost / 2, lost) == lost);
  }
}

namespace {

constexpr double kBounce = 0.2007;  // s
constexpr double kGravity = 9.81;

/// A ball that falls from its own height on a table at z = 0, and springs back with 0.9 of its speed.
Capture bouncing_ball(double noise, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, noise);
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(60, 0.0, 59 * 0.007);
  Eigen::VectorXd x(60);
  Eigen::VectorXd z(60);
  for (Index k = 0; k < 60; ++k) {
    const double since = times[k] - kBounce;
    const double up = since > 0.0 ? 0.9 * kGravity * kBounce : -kGravity * kBounce;
    x[k] = 5.0 * times[k] - (since > 0.0 ? 0.3 * since : 0.0) + normal(random);
    z[k] = up * since - 0.5 * kGravity * since * since + normal(random);
  }
  return capture_of(times, {{"x", "m", x}, {"z", "m", z}});
}

}  // namespace

TEST_CASE("a capture is cut before the bounce") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Capture ball = bouncing_ball(0.001, seed);
    const BeforeImpact cut = before_impact(ball, {.quantities = {"x", "z"}});
    REQUIRE(cut.impact_time);
    // 1.9 g t = 3.7 m/s down and 0.3 m/s along; slopes of 4 frames err by 0.06 m/s, and the frame at which a
    // kink is seen by one.
    CHECK(std::abs(*cut.impact_time - kBounce) < 0.0075);
    CHECK(std::abs(cut.jump - 3.75) < 0.5);
    const double last = cut.capture.times[cut.capture.frame_count() - 1];
    CHECK(last < kBounce);
    CHECK(last > kBounce - 0.022);
    CHECK(cut.capture.channel("z").values.size() == cut.capture.frame_count());
    CHECK(cut.capture.notes.size() == 1);
  }
}

TEST_CASE("neither free fall nor one wrong frame is an impact") {
  Capture ball = bouncing_ball(0.001, 1);
  ball.times.conservativeResize(28);
  for (Channel& channel : ball.channels) channel.values.conservativeResize(28);
  CHECK_FALSE(before_impact(ball, {.quantities = {"x", "z"}}).impact_time);
  for (Index k = 0; k < 28; ++k) {
    Capture wrong = ball;
    wrong.channels[1].values[k] += 0.3;
    CHECK_FALSE(before_impact(wrong, {.quantities = {"x", "z"}}).impact_time);
  }
  ball.channels[1].values.segment(5, 3).setConstant(NAN);
  const BeforeImpact uncut = before_impact(ball, {.quantities = {"x", "z"}});
  CHECK(uncut.capture.frame_count() == 28);
  CHECK(uncut.capture.notes.empty());
  CHECK(error_of<samara::ArgumentError>([&] { before_impact(ball); }) ==
        "capture \"ball\" does not measure \"y\"; known: x, z");
}

TEST_CASE("a frame that the clock seems to lack is no impact, and hides none") {
  const auto fast = [](Index frames) {
    Capture ball = bouncing_ball(0.001, 1);
    ball.channels[0].values *= 1.8;  // 9 m/s along
    ball.times.conservativeResize(frames);
    for (Channel& channel : ball.channels) channel.values.conservativeResize(frames);
    return ball;
  };
  for (Index k = 4; k < 24; ++k) {
    Capture falling = fast(28);
    falling.times.tail(28 - k).array() += 0.007;
    CHECK_FALSE(before_impact(falling, {.quantities = {"x", "z"}}).impact_time);
    Capture bouncing = fast(60);
    bouncing.times.tail(60 - k).array() += 0.007;
    const BeforeImpact cut = before_impact(bouncing, {.quantities = {"x", "z"}});
    REQUIRE(cut.impact_time);
    CHECK(std::abs(*cut.impact_time - 0.007 - kBounce) < 0.0075);
  }
  // Nor are frames that are missing.
  Capture falling = fast(28);
  for (Channel& channel : falling.channels) channel.values.segment(12, 2).setConstant(NAN);
  CHECK_FALSE(before_impact(falling, {.quantities = {"x", "z"}}).impact_time);
}

TEST_CASE("a track that goes on with another body, or after a long gap, is several pieces") {
  Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(60, 0.0, 1.18);
  times.tail(20).array() += 0.5;
  Eigen::VectorXd x = 2.0 * times;
  x.tail(45).array() += 0.3;  // 17 m/s from frame 14 to 15
  x.segment(25, 3).setConstant(NAN);
  const auto pieces = continuous_parts(capture_of(times, {{"x", "m", x}}),
                                       {.quantities = {"x"}, .longest_gap = 0.1, .fastest = 5.0});
  REQUIRE(pieces.size() == 3);
  CHECK(pieces[0].frame_count() == 15);
  CHECK(pieces[1].frame_count() == 25);
  CHECK(pieces[2].frame_count() == 20);
  CHECK(pieces[1].id == "ball#2");
  CHECK(pieces[1].times[0] == times[15]);
  CHECK(pieces[2].channel("x").values[0] == x[40]);
  const auto longest = continuous_parts(capture_of(times, {{"x", "m", x}}),
                                        {.quantities = {"x"}, .longest_gap = 1.0, .least_frames = 30});
  REQUIRE(longest.size() == 1);
  CHECK(longest[0].id == "ball");
  CHECK(longest[0].notes.empty());
}

TEST_CASE("outliers become missing values and are counted") {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal(0.0, 0.002);
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(80, 0.0, 0.79);
  Eigen::VectorXd x(80);
  Eigen::VectorXd theta(80);
  Eigen::MatrixX4d q(80, 4);
  for (Index k = 0; k < 80; ++k) {
    x[k] = std::sin(4.0 * times[k]) + normal(random);
    theta[k] = std::remainder(15.0 * times[k] + normal(random), 2.0 * std::numbers::pi);
    const double half = 5.0 * times[k] + normal(random);
    q.row(k) << std::cos(half), 0.0, std::sin(half), 0.0;
    if (k % 7 == 0) q.row(k) *= -1.0;
  }
  x[30] += 0.2;
  x[31] += 0.2;
  theta[50] += 0.5;
  q.row(11) << 1.0, 0.0, 0.0, 0.0;
  const Capture capture = capture_of(times, {{"x", "m", x},
                                             {"theta", "1", theta},
                                             {"qw", "1", q.col(0)},
                                             {"qx", "1", q.col(1)},
                                             {"qy", "1", q.col(2)},
                                             {"qz", "1", q.col(3)}});
  const WithoutOutliers clean =
      without_outliers(capture, {.bandwidth = 0.15}, {{"theta", 2.0 * std::numbers::pi}});
  CHECK(clean.frames ==
        std::map<std::string, std::vector<int>>{{"attitude", {11}}, {"theta", {50}}, {"x", {30, 31}}});
  for (const Channel& channel : clean.capture.channels) {
    for (Index k = 0; k < 80; ++k) {
      const double before = capture.channel(channel.quantity).values[k];
      CHECK((std::isnan(channel.values[k]) || channel.values[k] == before));
    }
  }
  CHECK(std::isnan(clean.capture.channel("qz").values[11]));
  CHECK(clean.capture.notes[0] == "1 of 80 frames of attitude taken out: far from their neighbours");
}
