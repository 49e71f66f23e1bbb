#include "samara/identification/smoothing/smoothing.h"

#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "files.h"
#include "samara/identification/smoothing/continuous_angles.h"
#include "samara/identification/smoothing/smoothing_attitude.h"

using namespace samara::identification;
using Eigen::Index;

namespace {

constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();

/// `count` times about `interval` apart, jittered by up to a third of it.
Eigen::VectorXd jittered_times(int count, double interval, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> jitter(-0.33, 0.33);
  Eigen::VectorXd times(count);
  for (int k = 0; k < count; ++k) times[k] = interval * (k + jitter(random));
  return times;
}

template <class Function>
Eigen::VectorXd values_of(const Function& f, const Eigen::VectorXd& times) {
  return times.unaryExpr([&](double t) { return f(t); });
}

void add_noise_to(Eigen::VectorXd& values, double sigma, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0.0, sigma);
  for (double& value : values) value += normal(random);
}

double quartic(double t) {
  return 1.0 + t * (-2.0 + t * (0.5 + t * (3.0 - 4.0 * t)));
}
double quartic_rate(double t) {
  return -2.0 + t * (1.0 + t * (9.0 - 16.0 * t));
}
double quartic_acceleration(double t) {
  return 1.0 + t * (18.0 - 48.0 * t);
}

double swing(double t) {
  return std::sin(7.0 * t) + 0.4 * t;
}
double swing_rate(double t) {
  return 7.0 * std::cos(7.0 * t) + 0.4;
}
double swing_acceleration(double t) {
  return -49.0 * std::sin(7.0 * t);
}

}  // namespace

TEST_CASE("a polynomial of the smoothing's degree is reproduced exactly, ends and gaps included") {
  const Eigen::VectorXd times = jittered_times(60, 0.01, 1);
  Eigen::MatrixXd values(60, 2);
  values.col(0) = values_of(quartic, times);
  values.col(1) = 3.0 * times;
  values.block(20, 0, 11, 1).setConstant(kUnseen);
  Eigen::VectorXd at(5);
  at << times[0], 0.123, times[25], 0.4, times[59];
  const Smoothed smoothed = smooth(times, values, at, {.bandwidth = 0.12});
  for (Index k = 0; k < at.size(); ++k) {
    // Rounding of 1e-16, times n!/reach^n: 1/0.1 and 2/0.1^2 with a margin for the ends.
    CHECK(std::abs(smoothed.value(k, 0) - quartic(at[k])) < 1e-13);
    CHECK(std::abs(smoothed.rate(k, 0) - quartic_rate(at[k])) < 1e-11);
    CHECK(std::abs(smoothed.acceleration(k, 0) - quartic_acceleration(at[k])) < 1e-8);
    CHECK(std::abs(smoothed.rate(k, 1) - 3.0) < 1e-11);
    CHECK(smoothed.value_error(k, 0) < 1e-13);
  }
  CHECK(smoothed.outlier.count() == 0);
}

TEST_CASE("smoothing converges with the order of its degree as the bandwidth shrinks") {
  // Inside, frames symmetric about the time: degree d reproduces t^(d+1) in the value for even d only, so
  // that the value errs by h^(d+2), the rate by h^d, the acceleration by h^d. At the end of the record, where
  // they lie on one side: h^(d+1), h^d, h^(d-1).
  const int degree = GENERATE(2, 4);
  const double exact = 0.3;
  const auto errors = [&](double bandwidth, bool at_end) -> Eigen::Vector3d {
    const int count = 401;
    const Eigen::VectorXd times =
        at_end ? Eigen::VectorXd::LinSpaced(count, exact, exact + 2.0 * bandwidth).eval()
               : Eigen::VectorXd::LinSpaced(count, exact - bandwidth, exact + bandwidth).eval();
    const Smoothed s = smooth(times, values_of(swing, times), Eigen::VectorXd::Constant(1, exact),
                              {.degree = degree, .bandwidth = bandwidth, .outlier_threshold = INFINITY});
    return {std::abs(s.value(0, 0) - swing(exact)), std::abs(s.rate(0, 0) - swing_rate(exact)),
            std::abs(s.acceleration(0, 0) - swing_acceleration(exact))};
  };
  const auto order = [&](bool at_end) -> Eigen::Vector3d {
    return (errors(0.2, at_end).array() / errors(0.1, at_end).array()).log() / std::log(2.0);
  };
  const Eigen::Vector3d inside = order(false);
  CHECK(inside[0] > degree + 2 - 0.2);
  CHECK(inside[1] > degree - 0.2);
  CHECK(inside[2] > degree - 0.2);
  const Eigen::Vector3d at_end = order(true);
  CHECK(at_end[0] > degree + 1 - 0.4);
  CHECK(at_end[1] > degree - 0.4);
  CHECK(at_end[2] > degree - 1 - 0.4);
}

TEST_CASE("standard errors cover the truth as often as they say") {
  // 250 records, three times each (an end, the middle, beside a gap). The share of 250 within 1.96 errors has
  // a standard deviation of 1.4 %; the noise, estimated from 45 frames, takes off about half a per cent.
  int inside[3][3] = {};
  const int records = 250;
  double noise = 0.0;
  for (int record = 0; record < records; ++record) {
    std::mt19937_64 random(static_cast<unsigned>(record) + 10);
    const Eigen::VectorXd times = jittered_times(55, 0.01, static_cast<unsigned>(record));
    Eigen::VectorXd values = values_of(quartic, times);
    add_noise_to(values, 0.02, random);
    values.segment(30, 8).setConstant(kUnseen);
    const Eigen::Vector3d at(times[0], 0.15, 0.29);
    const Smoothed s = smooth(times, values, at, {.bandwidth = 0.15});
    noise += s.noise[0] / records;
    for (int k = 0; k < 3; ++k) {
      const double t = at[k];
      inside[k][0] += std::abs(s.value(k, 0) - quartic(t)) < 1.96 * s.value_error(k, 0);
      inside[k][1] += std::abs(s.rate(k, 0) - quartic_rate(t)) < 1.96 * s.rate_error(k, 0);
      inside[k][2] +=
          std::abs(s.acceleration(k, 0) - quartic_acceleration(t)) < 1.96 * s.acceleration_error(k, 0);
    }
  }
  for (const auto& place : inside) {
    for (const int count : place) {
      CHECK(count > 0.9 * records);
      CHECK(count < 0.985 * records);
    }
  }
  CHECK(std::abs(noise - 0.02) < 0.0005);
}

TEST_CASE("standard errors hold where the source has averaged neighbouring frames") {
  // A running mean of five frames; without being told, errors are about half of what they should be.
  int inside[3] = {};
  int inside_untold = 0;
  const int records = 200;
  double noise = 0.0;
  for (int record = 0; record < records; ++record) {
    std::mt19937_64 random(static_cast<unsigned>(record));
    Eigen::VectorXd white = Eigen::VectorXd::Zero(94);
    add_noise_to(white, 0.02, random);
    const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(90, 0.0, 0.89);
    Eigen::VectorXd values = values_of(quartic, times);
    for (Index k = 0; k < 90; ++k) values[k] += white.segment(k, 5).mean();
    const double t = record % 2 == 0 ? 0.0 : 0.4;
    const Eigen::VectorXd at = Eigen::VectorXd::Constant(1, t);
    const Smoothed s =
        smooth(times, values, at, {.bandwidth = 0.2, .averaged_frames = 5, .outlier_threshold = INFINITY});
    noise += s.noise[0] / records;
    inside[0] += std::abs(s.value(0, 0) - quartic(t)) < 1.96 * s.value_error(0, 0);
    inside[1] += std::abs(s.rate(0, 0) - quartic_rate(t)) < 1.96 * s.rate_error(0, 0);
    inside[2] += std::abs(s.acceleration(0, 0) - quartic_acceleration(t)) < 1.96 * s.acceleration_error(0, 0);
    const Smoothed untold = smooth(times, values, at, {.bandwidth = 0.2, .outlier_threshold = INFINITY});
    inside_untold += std::abs(untold.value(0, 0) - quartic(t)) < 1.96 * untold.value_error(0, 0);
  }
  for (const int count : inside) {
    // 1.5 % standard deviation
    CHECK(count > 0.9 * records);
    CHECK(count < 0.99 * records);
  }
  CHECK(inside_untold < 0.8 * records);
  CHECK(std::abs(noise - 0.02 / std::sqrt(5.0)) < 0.0008);
}

TEST_CASE("one frame in twenty that is grossly wrong changes nothing, and is named") {
  std::mt19937_64 random(5);
  int missed = 0;
  int invented = 0;
  double largest = 0.0;
  double noise = 0.0;
  for (unsigned record = 0; record < 20; ++record) {
    const Eigen::VectorXd times = jittered_times(120, 0.01, record);
    Eigen::VectorXd values = values_of(swing, times);
    add_noise_to(values, 0.003, random);
    Eigen::Array<bool, Eigen::Dynamic, 1> wrong(120);
    for (Index k = 0; k < 120; ++k) {
      wrong[k] = std::uniform_real_distribution<double>()(random) < 0.05;
      if (wrong[k]) values[k] += std::uniform_real_distribution<double>(0.2, 3.0)(random);
    }
    const Smoothed s = smooth(times, values, times.segment(2, 116), {.bandwidth = 0.15});
    // At the very ends a polynomial predicts too badly to tell smaller ones.
    missed += static_cast<int>((wrong && !s.outlier.col(0)).segment(2, 116).count());
    invented += static_cast<int>((!wrong && s.outlier.col(0)).count());
    noise += s.noise[0] / 20.0;
    const Eigen::VectorXd error = s.value - values_of(swing, times.segment(2, 116));
    largest = std::max(largest, (error.array() / s.value_error.col(0).array()).abs().maxCoeff());
  }
  CHECK(missed == 0);
  CHECK(invented <= 2);
  CHECK(std::abs(noise - 0.003) < 0.0002);
  CHECK(largest < 6.0);  // of 2320 values
}

TEST_CASE("values rounded to a coarse step are not outliers of those that happen to fit") {
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(100, 0.0, 0.99);
  Eigen::VectorXd values(100);
  for (Index k = 0; k < 100; ++k) values[k] = k < 60 ? 0.0 : std::round(40.0 * std::pow(times[k] - 0.6, 2));
  CHECK(smooth(times, values, times, {.bandwidth = 0.15}).outlier.count() == 0);
}

TEST_CASE("where all frames are farther off than the stated noise, enough of them still count") {
  // Millimetres taken for metres: the noise is a thousand times what it was said to be.
  std::mt19937_64 random(3);
  const Eigen::VectorXd times = jittered_times(31, 1.0 / 60.0, 4);
  Eigen::VectorXd values = values_of(swing, times);
  add_noise_to(values, 0.3, random);
  const Smoothed s = smooth(times, values, times, {.bandwidth = 0.2, .noise = 3e-4});
  CHECK(s.value.allFinite());
  CHECK(s.rate.allFinite());
  CHECK(s.outlier.count() <= 31 - 6);  // a quartic and one more frame are left
}

TEST_CASE("an angle is unwrapped through full turns, gaps and a wrong frame") {
  // 2.4 rad a frame: only the rate of the frames before says that the next multiple is meant.
  const double two_pi = 2.0 * std::acos(-1.0);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, 0.05);
  for (const double period : {two_pi, 0.5 * two_pi}) {
    Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(80, 0.0, 0.79);
    Eigen::VectorXd truth(80);
    for (Index k = 0; k < 80; ++k) {
      const double t = times[k];
      truth[k] = period / two_pi * (30.0 * t + 230.0 * t * t - 90.0 * t * t * t);
    }
    Eigen::VectorXd seen = truth;
    for (double& angle : seen) angle = std::remainder(angle + normal(random), period);
    seen.segment(30, 4).setConstant(kUnseen);
    seen[50] = std::remainder(seen[50] + 0.4 * period, period);
    const Eigen::VectorXd angles = unwrapped(times, seen, period);
    for (Index k = 0; k < 80; ++k) {
      if (std::isnan(seen[k])) {
        CHECK(std::isnan(angles[k]));
      } else if (k != 50) {
        CHECK(std::abs(angles[k] - truth[k]) < 0.3);
      }
    }
    const Smoothed s = smooth_angle(times, seen, period, times.segment(40, 1), {.bandwidth = 0.12});
    const double rate = period / two_pi * (30.0 + 460.0 * times[40] - 270.0 * times[40] * times[40]);
    CHECK(std::abs(s.rate(0, 0) - rate) < 4.0 * s.rate_error(0, 0));
    CHECK(s.outlier(50, 0));
    CHECK(s.outlier.count() == 1);
  }
}

TEST_CASE("smoothing refuses what has no meaning") {
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(10, 0.0, 0.9);
  const Eigen::MatrixXd values = Eigen::MatrixXd::Zero(10, 1);
  const Eigen::VectorXd at = Eigen::VectorXd::Constant(1, 0.5);
  const auto refusal = [&](const Eigen::VectorXd& t, const Eigen::MatrixXd& v, const Eigen::VectorXd& a,
                           const SmoothingOptions& options) {
    return error_of<samara::ArgumentError>([&] { smooth(t, v, a, options); });
  };
  CHECK(refusal(times, values, at, {}) == "no exception");
  CHECK(refusal(times, values, at, {.degree = 7}) == "smoothing: degree is 7; 2 to 6 was expected");
  CHECK(refusal(times, values, at, {.bandwidth = 0.0}) ==
        "smoothing: bandwidth [s] is 0; a positive finite number was expected");
  CHECK(refusal(times.head(9), values, at, {}) == "there are 9 times for 10 frames");
  CHECK(refusal(times, values, at * 3.0, {}) == "1.5 s was asked for; the frames are from 0 s to 0.9 s");
  CHECK(refusal(times.reverse(), values, at, {}) ==
        "time 0.8 s follows 0.9 s; times that increase were expected");
  Eigen::MatrixXd few = values;
  few.topRows(5).setConstant(kUnseen);
  CHECK(refusal(times, few, at, {}) ==
        "a channel is seen in 5 frames; at least 6 were expected for degree 4");
  few(9, 0) = INFINITY;
  CHECK(refusal(times, few, at, {}) == "channel 0 has an infinite value");
  CHECK(error_of<samara::ArgumentError>([&] { unwrapped(times, values.col(0), 0.0); }) ==
        "the period of an angle is 0; more than 0 was expected");
}

TEST_CASE("frames that scatter far more than the noise that is given are not outliers of it") {
  std::mt19937_64 random(11);
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(73, 0.0, 0.3);
  Eigen::VectorXd values = values_of(swing, times);
  add_noise_to(values, 0.5, random);
  for (const double noise : {1e-12, 1e-3, 0.05}) {
    const Smoothed smoothed = smooth(times, values, times, {.degree = 2, .bandwidth = 0.02, .noise = noise});
    // Of so few neighbours a normal frame is seldom 5 of their deviations away.
    CHECK(smoothed.outlier.count() <= 3);
    CHECK(smoothed.value.allFinite());
  }
  // A threshold that no frame meets.
  CHECK(smooth(times, values, times, {.outlier_threshold = 1e-6}).value.allFinite());
  // Attitudes, too.
  Eigen::MatrixX4d q(73, 4);
  for (Index k = 0; k < 73; ++k) q.row(k) << std::cos(values[k]), 0.0, std::sin(values[k]), 0.0;
  const SmoothedAttitude attitude = smooth_attitude(times, q, times, {.noise = 1e-9});
  CHECK(attitude.attitude.allFinite());
  CHECK(attitude.outlier.count() <= 3);
}

TEST_CASE("a noise that is far too small makes no frame an outlier") {
  // Few frames of a curve that polynomials do not follow: all stand off by many times such a noise.
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(16, 0.0, 6.0);
  const Eigen::MatrixXd values = (3.0 * times.array()).sin().matrix();
  const Smoothed smoothed = smooth(times, values, times, {.bandwidth = 2.0, .noise = 1e-9});
  CHECK_FALSE(smoothed.outlier.any());
  CHECK(smoothed.value.allFinite());
}

TEST_CASE("outliers that would leave a polynomial through all other frames are none") {
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(8, 0.0, 0.7);
  Eigen::VectorXd values(8);
  values << 0.001, 0.0019, -0.561, -0.001, 0.0003, -0.0009, -0.0023, -0.0018;
  const Smoothed smoothed = smooth(times, values, times, {.degree = 4});
  CHECK(smoothed.noise[0] > 1e-4);
  CHECK(smoothed.outlier.count() <= 8 - 6);
  // Where others are left, the one that is wrong is found.
  values << 0.001, 0.002, -0.561, -0.001, 0.0, -0.001, -0.002, -0.002;
  CHECK(smooth(times, values, times, {.degree = 4}).outlier.count() == 1);
  values.head(5) << 3.0, 5.0, -13.0, 25.0, 2.0;
  CHECK(
      smooth(times.head(5), values.head(5), times.head(5), {.degree = 2, .outlier_threshold = 1.0}).noise[0] >
      1.0);
}
