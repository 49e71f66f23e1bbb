#include "samara/models/trajectories/delayed_source.h"

#include <cmath>
#include <functional>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::models;

namespace {

/// x = a f(t), and y = a^2 f(t/2).
class ShapedFamily final : public TrajectoryFamily {
 public:
  explicit ShapedFamily(std::function<double(double)> shape, double end_time = INFINITY)
      : shape_(std::move(shape)) {
    info_.coordinates = {{"a", "1", false, 0.0, 10.0}};
    info_.outputs = {{"x", "m"}, {"y", "m"}};
    info_.end_time = end_time;
  }

  const FamilyInfo& info() const override { return info_; }
  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs) const override {
    for (const double time : times) {
      if (time < 0.0) throw samara::ArgumentError("a time before the start");
      if (time > info_.end_time) throw samara::OutsideBoxError("a time after the end");
    }
    REQUIRE(std::ranges::is_sorted(times));
    asked = times.size();
    REQUIRE(outputs.size() == 2);
    return std::make_unique<Source>(shape_, times);
  }

  mutable std::size_t asked = 0;  ///< times of the last source

 private:
  struct Source final : TrajectorySource {
    Source(std::function<double(double)> of_time, const std::vector<double>& at_times)
        : shape(std::move(of_time)), times(at_times) {}
    TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                               Eigen::MatrixXd* derivatives) override {
      for (std::size_t row = 0; row < times.size(); ++row) {
        const auto at = static_cast<Eigen::Index>(row);
        const double f = shape(times[row]), g = shape(0.5 * times[row]);
        values.row(at) << q[0] * f, q[0] * q[0] * g;
        if (derivatives) derivatives->row(at) << f, 2.0 * q[0] * g;
      }
      return {};
    }
    std::function<double(double)> shape;
    std::vector<double> times;
  };

  std::function<double(double)> shape_;
  FamilyInfo info_;
};

/// Frames one apart, from 2 on.
std::vector<double> frame_times(int count) {
  std::vector<double> times;
  for (int k = 0; k < count; ++k) times.push_back(2.0 + k);
  return times;
}

struct Evaluated {
  Eigen::MatrixXd values, derivatives;
};

Evaluated at_delay(const TrajectoryFamily& family, const Interval& range, const FrameMean& mean,
                   const std::vector<double>& times, double a, double delay) {
  const auto source = delayed_source(family, range, mean, times, {"x", "y"}, {0});
  const auto rows = static_cast<Eigen::Index>(times.size());
  Evaluated result{Eigen::MatrixXd::Zero(rows, 2), Eigen::MatrixXd::Zero(rows, 4)};
  REQUIRE(source->evaluate(std::vector{a, delay}, result.values, &result.derivatives));
  return result;
}

/// The largest error of x over many delays, of a motion of `w` rad from frame to frame.
double wave_error(double w, const Interval& range) {
  const ShapedFamily family([w](double t) { return std::sin(w * t + 0.3); });
  const std::vector<double> times = frame_times(41);
  double largest = 0.0;
  for (int k = 0; k <= 50; ++k) {
    const double delay = range.lower + range.width() * k / 50.0;
    const Evaluated result = at_delay(family, range, {}, times, 1.0, delay);
    for (std::size_t row = 0; row < times.size(); ++row) {
      const double truth = std::sin(w * (times[row] + delay) + 0.3);
      largest = std::max(largest, std::abs(result.values(static_cast<Eigen::Index>(row), 0) - truth));
    }
  }
  return largest;
}

}  // namespace

TEST_CASE("a delayed source shows the trajectory later by the delay, with all derivatives") {
  constexpr double w = 0.6;
  const auto shape = [](double t) { return std::sin(w * t); };
  const ShapedFamily family(shape);
  const std::vector<double> times = frame_times(20);
  for (const double delay : {-1.9, -0.31, 0.0, 0.5, 2.4}) {
    const Evaluated result = at_delay(family, {-2.0, 2.5}, {}, times, 1.5, delay);
    for (std::size_t k = 0; k < times.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      const double t = times[k] + delay;
      // The bound is 2e-6 at w = 1, times 0.6^10 here, and for rates some ten times that.
      CHECK(std::abs(result.values(row, 0) - 1.5 * shape(t)) < 1e-8);
      CHECK(std::abs(result.values(row, 1) - 2.25 * shape(0.5 * t)) < 1e-8);
      CHECK(std::abs(result.derivatives(row, 0) - shape(t)) < 1e-8);
      CHECK(std::abs(result.derivatives(row, 1) - 3.0 * shape(0.5 * t)) < 1e-8);
      CHECK(std::abs(result.derivatives(row, 2) - 1.5 * w * std::cos(w * t)) < 1e-7);
      CHECK(std::abs(result.derivatives(row, 3) - 1.125 * w * std::cos(0.5 * w * t)) < 1e-7);
    }
  }
}

TEST_CASE(
    "the error of a delay falls with the tenth power of the motion's speed, below the bound it is made for") {
  const Interval wide{-2.0, 2.0};
  CHECK(wave_error(1.0, wide) < 2e-6);
  // J_10(w L/2) of a wave, L = 4: by 2^9.6 from w = 2 to 1, by 2^9.9 from 1 to 1/2.
  CHECK(std::log2(wave_error(2.0, wide) / wave_error(1.0, wide)) > 9.0);
  CHECK(std::log2(wave_error(1.0, wide) / wave_error(0.5, wide)) > 9.0);
  // Narrow ranges ask in the same pieces.
  CHECK(wave_error(1.0, {0.1, 0.2}) < 2e-6);
}

TEST_CASE("a delay asks for less than three times a frame, however wide its range") {
  const ShapedFamily family([](double t) { return t; });
  for (const double width : {0.01, 1.0, 3.7}) {
    at_delay(family, {0.0, width}, {}, frame_times(101), 1.0, 0.0);
    CHECK(static_cast<double>(family.asked) < 2.4 * (101.0 + width));
  }
  SECTION("and over a long gap between frames for none") {
    std::vector<double> times = frame_times(21);
    for (const double time : frame_times(20)) times.push_back(1000.0 + time);
    at_delay(family, {0.0, 1.0}, {}, times, 1.0, 0.3);
    CHECK(family.asked < 120);
  }
}

TEST_CASE("a cubic is shifted to round-off, also by means of frames, and the state at the end is not") {
  const auto cubic = [](double t) { return 1.0 + t * (2.0 - t * (0.3 - 0.01 * t)); };
  const ShapedFamily family(cubic);
  std::vector<double> times = frame_times(12);
  // Within what the frames reach, at none of their times.
  times.push_back(12.4);
  const FrameMean mean{.frames = 3, .interval = 0.5, .last_is_state = true};
  for (const double delay : {0.0, 0.77, 1.5}) {
    const Evaluated result = at_delay(family, {0.0, 1.5}, mean, times, 2.0, delay);
    for (Eigen::Index row = 0; row < 12; ++row) {
      const double t = times[static_cast<std::size_t>(row)] + delay;
      CHECK(std::abs(result.values(row, 0) - 2.0 * (cubic(t - 0.5) + cubic(t) + cubic(t + 0.5)) / 3.0) <
            1e-12);
    }
    CHECK(result.values(12, 0) == 2.0 * cubic(12.4));
    CHECK(result.derivatives(12, 0) == cubic(12.4));
    CHECK(result.derivatives.row(12).tail<2>().norm() == 0.0);
  }
}

TEST_CASE("the derivative by a delay is that of the values, and steady between pieces") {
  const ShapedFamily family([](double t) { return std::sin(1.5 * t); });
  const std::vector<double> times = frame_times(15);
  const FrameMean mean{.frames = 5, .interval = 0.4};
  constexpr double kStep = 1e-5;
  for (int k = 0; k <= 40; ++k) {
    const double delay = -0.9 + 0.05 * k;
    const Evaluated at = at_delay(family, {-1.0, 1.2}, mean, times, 1.0, delay);
    const Evaluated up = at_delay(family, {-1.0, 1.2}, mean, times, 1.0, delay + kStep);
    const Evaluated down = at_delay(family, {-1.0, 1.2}, mean, times, 1.0, delay - kStep);
    // Rounding of 1e-15 over 1e-5, truncation of 1e-10 times third derivatives.
    CHECK(((up.values - down.values) / (2.0 * kStep) - at.derivatives.rightCols<2>()).cwiseAbs().maxCoeff() <
          1e-8);
  }
}

TEST_CASE("a delay that is held asks for the very times") {
  const auto shape = [](double t) {
    return std::exp(-t) * std::sin(40.0 * t);
  };  // no polynomial could follow
  const ShapedFamily family(shape);
  const std::vector<double> times = frame_times(9);
  const Evaluated result = at_delay(family, {0.3, 0.3}, {}, times, 1.0, 0.3);
  CHECK(family.asked == 9);
  for (Eigen::Index row = 0; row < 9; ++row)
    CHECK(result.values(row, 0) == shape(times[static_cast<std::size_t>(row)] + 0.3));
  at_delay(family, {0.3, 0.3}, {.frames = 3, .interval = 1.0}, times, 1.0, 0.3);
  CHECK(family.asked == 11);  // neighbours have theirs in common
}

TEST_CASE("ranges that lead out of the trajectory, or are none, are refused") {
  const ShapedFamily family([](double t) { return t; }, 20.0);
  const auto source = [&](double lower, double upper) {
    return delayed_source(family, {lower, upper}, {}, frame_times(10), {"x", "y"}, {0});
  };
  CHECK_THROWS_AS(source(-2.5, 0.0), samara::ArgumentError);
  CHECK_THROWS_AS(source(0.0, 9.5), samara::OutsideBoxError);
  CHECK_NOTHROW(source(-2.0, 9.0));
  CHECK_THROWS_WITH(source(1.0, 0.0), Catch::Matchers::Contains("ranges from 1 s to 0 s"));
  CHECK_THROWS_AS(source(std::nan(""), 0.0), samara::ArgumentError);
  CHECK_THROWS_AS(source(0.0, INFINITY), samara::ArgumentError);
}
