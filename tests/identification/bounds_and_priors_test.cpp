/// Minima at bounds of the box, and what priors make of standard errors: against closed forms.
#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "closed_form_family.h"
#include "samara/identification/fit/fit.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// Three captures of x = v a_i with noise; v(0) shared or own, everything else held.
struct Linear {
  std::vector<double> times = even_times(9, 2.0);
  Eigen::VectorXd a = BrakedFamily::depths(1.0, 1.0, times);
  std::vector<Capture> captures;
  FitOptions options;

  explicit Linear(double noise) {
    std::mt19937_64 random(3);
    for (const char* id : {"a", "b", "c"}) {
      captures.push_back(make_capture(id, times, 1.2 * a));
      add_noise(captures.back(), noise, random);
    }
    options.loss = {.kind = LossKind::none, .length_scale = 0.5};
    options.unknowns.fixed["k"] = 1.0;
    options.unknowns.offsets = std::vector<std::string>{};
    options.starts.count = 1;
  }

  /// Residuals of a capture over the loss scale.
  Eigen::VectorXd residual(std::size_t capture, double v) const {
    return (v * a - captures[capture].channels[0].values) / 0.5;
  }
  double information() const { return a.squaredNorm() / 0.25; }  ///< of one capture
};

}  // namespace

TEST_CASE("a prior counts in standard errors with its own deviation, frames with their scatter") {
  // With N = 3 a^T a/scale^2, P = 1/deviation^2 and the dispersion s^2 of the residuals, the estimate is
  // (N v_data + P mean)/(N + P): its variance is (s^2 N + P)/(N + P)^2. Of the unknown, data determine N/(N +
  // P).
  Linear linear(0.02);
  linear.options.unknowns.shared = std::vector<std::string>{"v(0)"};
  linear.options.priors.coordinates["v(0)"] = {.mean = 1.1, .deviation = 0.1};
  const FitResult result = fit(BrakedFamily(), linear.captures, linear.options);
  const Coefficient& v = result.coefficients.at(0);
  const double N = 3.0 * linear.information();
  const double P = 100.0;
  double squares = 0.0;
  double scores = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const Eigen::VectorXd r = linear.residual(c, v.value);
    squares += r.squaredNorm();
    scores += std::pow(linear.a.dot(r) / 0.5, 2);
  }
  const double dispersion = squares / (27 - N / (N + P));
  CHECK_THAT(v.naive_standard_error.value(), WithinRel(std::sqrt(dispersion * N + P) / (N + P), 1e-6));
  // Of each score the answer has taken the cluster's share of the information.
  const double left = 1.0 - N / 3.0 / (N + P);
  CHECK_THAT(v.standard_error.value(), WithinRel(std::sqrt(scores / left + P) / (N + P), 1e-6));
}

TEST_CASE("a prior of a capture's own coordinate counts in its error with its own deviation") {
  Linear linear(0.02);
  linear.options.priors.coordinates["v(0)"] = {.mean = 1.1, .deviation = 0.3};
  const FitResult result = fit(BrakedFamily(), linear.captures, linear.options);
  double squares = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    squares += linear.residual(c, result.captures.at(c).nuisances.at(0).value).squaredNorm();
  }
  const double N = linear.information();
  const double P = 1.0 / 0.09;
  const double expected = std::sqrt(squares / (27 - 3 * N / (N + P)) * N + P) / (N + P);
  for (const CaptureFit& capture : result.captures) {
    CHECK_THAT(capture.nuisances.at(0).standard_error.value(), WithinRel(expected, 1e-6));
  }
}

TEST_CASE("beside a robust loss a prior of a capture's own coordinate weighs as it does in the cost") {
  // Half of the frames lie beyond the bend: with m = mean(psi') they weigh m times what they do in J^T J.
  Linear linear(0.02);
  linear.options.loss = {.kind = LossKind::huber, .length_scale = 0.015};
  linear.options.priors.coordinates["v(0)"] = {.mean = 1.2, .deviation = 0.01};
  const FitResult result = fit(BrakedFamily(), linear.captures, linear.options);
  double squares = 0.0, slopes = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double v = result.captures.at(c).nuisances.at(0).value;
    const Eigen::VectorXd residual = 0.5 / 0.015 * linear.residual(c, v);
    for (const double r : residual) {
      squares += std::pow(std::min(std::abs(r), 1.0), 2);
      slopes += std::abs(r) <= 1.0 ? 1.0 : 0.0;
    }
  }
  const double m = slopes / 27;
  REQUIRE(m < 0.8);
  const double N = linear.a.squaredNorm() / (0.015 * 0.015);
  const double P = 1e4;
  const double K = 1.0 / (N + P / m);
  const double variance = squares / (27 - 3 * N * K) / (m * m);
  const double expected = K * std::sqrt(variance * N + P / (m * m));
  for (const CaptureFit& capture : result.captures) {
    CHECK_THAT(capture.nuisances.at(0).standard_error.value(), WithinRel(expected, 1e-5));
  }
}

TEST_CASE("a prior of own coordinates counts with its own deviation in the errors of shared ones, too") {
  // Frames scatter far less than the loss scale says; what is known of v(0) beforehand limits k.
  Linear linear(0.002);
  linear.options.unknowns.fixed.erase("k");
  linear.options.priors.coordinates["v(0)"] = {.mean = 1.2, .deviation = 0.05};
  for (Capture& capture : linear.captures) {
    capture.times = capture.times.head(3).eval();
    capture.channels[0].values = capture.channels[0].values.head(3).eval();
  }
  linear.options.loss.length_scale = 0.02;
  const FitResult result = fit(BrakedFamily(), linear.captures, linear.options);
  const double k = result.coefficients.at(0).value;
  // All unknowns at once: k, then v(0) of each capture.
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(9, 4);
  const std::vector<double> times(linear.times.begin(), linear.times.begin() + 3);
  double squares = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double v = result.captures.at(static_cast<std::size_t>(c)).nuisances.at(0).value;
    const double h = 1e-5;
    J.block(3 * c, 0, 3, 1) =
        (BrakedFamily::depths(k + h, v, times) - BrakedFamily::depths(k - h, v, times)) / (2.0 * h) / 0.02;
    J.block(3 * c, c + 1, 3, 1) = BrakedFamily::depths(k, 1.0, times) / 0.02;
    const Eigen::VectorXd& seen = linear.captures[static_cast<std::size_t>(c)].channels[0].values;
    squares += ((BrakedFamily::depths(k, v, times) - seen) / 0.02).squaredNorm();
  }
  Eigen::MatrixXd P = Eigen::Vector4d(0.0, 400.0, 400.0, 400.0).asDiagonal();
  const Eigen::MatrixXd data = J.transpose() * J;
  const Eigen::MatrixXd inverse = (data + P).inverse();
  const double dispersion = squares / (9.0 - (inverse * data).trace());
  const Eigen::MatrixXd covariance = inverse * (dispersion * data + P) * inverse;
  const double error = result.coefficients.at(0).naive_standard_error.value();
  CHECK_THAT(error, WithinRel(std::sqrt(covariance(0, 0)), 1e-4));
  CHECK(error > 2.0 * std::sqrt(dispersion * inverse(0, 0)));
}

TEST_CASE(
    "a capture's own coordinate at its bound counts in errors of shared ones with the deviation of its box") {
  // x = s + u with u at the end of its box, since a prior holds s lower. Frames say of s what they say of x, less the
  // deviation of the box of u: D = 1/(width^2/12 + scale^2/N). With the dispersion f of the residuals the variance is
  // (D^2 (width^2/12 + f scale^2/N) + P)/(D + P)^2.
  constexpr double kScale = 0.05, kWidth = 0.3, kMean = 0.5, kDeviation = 0.2;
  constexpr int kCount = 9;
  const ClosedFormFamily sum({.model = "sum of two",
                              .coordinates = {{"s", "m", false, -5.0, 5.0}, {"u", "m", false, 0.0, kWidth}},
                              .outputs = {{"x", "m"}}},
                             [](std::span<const double> q, double, auto& values, auto* derivatives) {
                               values << q[0] + q[1];
                               if (derivatives) *derivatives << 1.0, 1.0;
                             });
  std::mt19937_64 random(3);
  Capture capture = make_capture("a", even_times(kCount, 2.0), Eigen::VectorXd::Constant(kCount, 1.2));
  add_noise(capture, 0.02, random);
  FitOptions options;
  options.loss = {.kind = LossKind::none, .length_scale = kScale};
  options.unknowns.per_capture = {"u"};
  options.priors.coordinates["s"] = {.mean = kMean, .deviation = kDeviation};
  options.starts.count = 1;
  const FitResult result = fit(sum, std::vector{capture}, options);
  REQUIRE(result.captures.at(0).nuisances.at(0).at_bound);
  const double N = kCount / (kScale * kScale), P = 1.0 / (kDeviation * kDeviation);
  const double s = result.coefficients.at(0).value;
  const double dispersion =
      ((capture.channels[0].values.array() - s - kWidth) / kScale).matrix().squaredNorm() /
      (kCount - N / (N + P));
  const double of_box = kWidth * kWidth / 12.0, D = 1.0 / (of_box + 1.0 / N);
  const double expected = std::sqrt(D * D * (of_box + dispersion / N) + P) / (D + P);
  CHECK_THAT(result.coefficients.at(0).naive_standard_error.value(), WithinRel(expected, 1e-6));
}

TEST_CASE("a coefficient that only its prior holds has the prior's error, and is said to rest on it") {
  // k acts on x only through v(0)/k (1 - exp(-k t)); in captures of one instant the two cannot be told apart.
  const std::vector<double> times = {0.0, 1.0, 1.0 + 1e-9, 1.0 + 2e-9};
  std::vector<Capture> captures;
  for (const char* id : {"a", "b", "c"})
    captures.push_back(make_capture(id, times, BrakedFamily::depths(1.0, 1.2, times)));
  FitOptions options;
  options.loss = {.kind = LossKind::none, .length_scale = 1e-3};
  options.unknowns.shared = std::vector<std::string>{"k", "v(0)"};
  options.unknowns.offsets = std::vector<std::string>{};
  options.starts.count = 1;
  options.priors.coordinates["k"] = {.mean = 1.0, .deviation = 0.05};
  const FitResult result = fit(BrakedFamily(), captures, options);
  const Coefficient& k = result.coefficients.at(0);
  CHECK_THAT(k.standard_error.value(), WithinRel(0.05, 1e-3));
  CHECK_THAT(k.naive_standard_error.value(), WithinRel(0.05, 1e-3));
  // d ln v = d ln k (1 - x exp(-x)/(1 - exp(-x))), x = k t = 1
  const double slope = 1.2 * (1.0 - std::exp(-1.0) / (1.0 - std::exp(-1.0)));
  CHECK_THAT(result.coefficients.at(1).standard_error.value(), WithinRel(0.05 * slope, 1e-3));
  CHECK_THAT(text_of(result.warnings), Contains("alone do not determine") && Contains("rests on the priors"));
}

namespace {

/// k and v(0), shared and hard to tell apart in short captures; the truth is outside the box of v(0).
struct Bounded {
  std::vector<Capture> captures;
  FitOptions options;

  Bounded() {
    const std::vector<double> times = even_times(12, 0.4);
    std::mt19937_64 random(7);
    for (const char* id : {"a", "b", "c", "d"}) {
      captures.push_back(make_capture(id, times, BrakedFamily::depths(1.0, 1.1, times)));
      add_noise(captures.back(), 2e-3, random);
    }
    options.loss = {.kind = LossKind::none, .length_scale = 2e-3};
    options.unknowns.shared = std::vector<std::string>{"k", "v(0)"};
    options.unknowns.box["v(0)"] = {0.3, 1.0};
    options.unknowns.offsets = std::vector<std::string>{};
    options.starts.count = 6;
  }

  FitOptions held_at_bound() const {
    FitOptions held = options;
    held.unknowns.box.erase("v(0)");
    held.unknowns.fixed["v(0)"] = 1.0;
    held.unknowns.shared = std::vector<std::string>{"k"};
    return held;
  }
};

}  // namespace

TEST_CASE("with an unknown at its bound every converged start has the minimum of the others") {
  const Bounded bounded;
  const FitResult free = fit(BrakedFamily(), bounded.captures, bounded.options);
  const FitResult held = fit(BrakedFamily(), bounded.captures, bounded.held_at_bound());
  REQUIRE(free.coefficients.at(1).at_bound);
  for (const StartRecord& start : free.starts) {
    if (start.status != samara::Termination::converged) continue;
    CHECK_THAT(start.cost, WithinRel(held.cost, 1e-8));
    CHECK_THAT(start.coefficients.at(0), WithinRel(held.coefficients.at(0).value, 1e-5));
  }
}

TEST_CASE("an unknown that met a bound on its way leaves it again") {
  // The first start lies far off, so that steps overshoot the box; the minimum is inside.
  Bounded bounded;
  bounded.options.unknowns.box["v(0)"] = {0.3, 1.3};
  bounded.options.unknowns.box["k"] = {0.2, 5.0};
  bounded.options.starts.initial = {{"k", 4.9}, {"v(0)", 1.29}};
  const FitResult near = fit(BrakedFamily(), bounded.captures, bounded.options);
  REQUIRE_FALSE(near.coefficients.at(1).at_bound);
  for (const StartRecord& start : near.starts) CHECK_THAT(start.cost, WithinRel(near.cost, 1e-7));
}

TEST_CASE("the profile beside a coefficient at its bound is that with the coefficient held there") {
  Bounded bounded;
  bounded.options.uncertainty.profiles = true;
  const FitResult free = fit(BrakedFamily(), bounded.captures, bounded.options);
  const FitResult held = fit(BrakedFamily(), bounded.captures, bounded.held_at_bound());
  const Profile& with_free = free.profiles.at(0);
  const Profile& with_held = held.profiles.at(0);
  // Below its minimum k pulls v(0) farther out of the box: the same side of the profile in both.
  CHECK_THAT(with_free.dispersion, WithinRel(with_held.dispersion, 1e-4));
  CHECK_THAT(with_free.interval_upper.value() - with_free.best,
             WithinRel(with_held.interval_upper.value() - with_held.best, 1e-2) ||
                 WithinRel(with_held.best - with_held.interval_lower.value(), 1e-2));
}

TEST_CASE("the profile of a coefficient at its bound counts captures as that of a free one does") {
  // x = v a, and v is 1.025 in the mean of the captures. With N = a^T a/scale^2 of each, the dispersion is that of
  // their scatter, 4/3 sum (N (v - mean))^2 over 4 N.
  Bounded bounded;
  const std::vector<double> times = even_times(12, 0.4);
  const Eigen::Vector4d v(0.9, 1.0, 1.05, 1.15);
  for (std::size_t c = 0; c < 4; ++c)
    bounded.captures[c].channels[0].values =
        BrakedFamily::depths(1.0, v[static_cast<Eigen::Index>(c)], times);
  bounded.options.unknowns.fixed["k"] = 1.0;
  bounded.options.unknowns.shared = std::vector<std::string>{"v(0)"};
  bounded.options.uncertainty.profiles = true;
  bounded.options.starts.count = 1;
  const FitResult held = fit(BrakedFamily(), bounded.captures, bounded.options);
  REQUIRE(held.coefficients.at(0).at_bound);
  const double N = BrakedFamily::depths(1.0, 1.0, times).squaredNorm() / (2e-3 * 2e-3);
  const double scatter = (v.array() - v.mean()).matrix().squaredNorm();
  const Profile& profile = held.profiles.at(0);
  CHECK_THAT(profile.dispersion, WithinRel(N * scatter / 3.0, 1e-6));
  CHECK_THAT(profile.degrees_of_freedom, WithinAbs(3.0, 1e-9));

  bounded.options.unknowns.box["v(0)"] = {0.3, 3.0};
  const FitResult free = fit(BrakedFamily(), bounded.captures, bounded.options);
  REQUIRE_FALSE(free.coefficients.at(0).at_bound);
  CHECK_THAT(profile.dispersion, WithinRel(free.profiles.at(0).dispersion, 1e-4));
  CHECK_THAT(profile.degrees_of_freedom, WithinAbs(free.profiles.at(0).degrees_of_freedom, 1e-9));
  // Of one capture frames are all there is.
  bounded.options.unknowns.box["v(0)"] = {0.3, 1.0};
  const FitResult single = fit(BrakedFamily(), std::vector{bounded.captures.back()}, bounded.options);
  REQUIRE(single.coefficients.at(0).at_bound);
  CHECK(single.profiles.at(0).degrees_of_freedom == 12.0);
}

TEST_CASE("a later start without trajectories does not change the errors of the best one") {
  // Runge-Kutta steps of 10 ms give no trajectory of a coin with a drag thousands of times too large.
  const auto family = step_trajectories(samara::models::find_model("vertical_fall"), coin_fixed(),
                                        {{"C_D", {0.6, 1e6}}, {"v(0)", {-0.4, 0.8}}}, 0.01);
  std::mt19937_64 random(5);
  std::vector<Capture> captures;
  for (const char* id : {"a", "b", "c"}) {
    captures.push_back(coin_capture(id, 1.2, 0.05, 0.0));
    add_noise(captures.back(), 2e-4, random);
  }
  FitOptions options;
  options.loss = {.kind = LossKind::none, .length_scale = 2e-4};
  options.segments.length = 0.15;
  options.starts.initial["C_D"] = 1.0;
  options.uncertainty.profiles = true;
  options.starts.count = 1;
  const FitResult one = fit(*family, captures, options);
  options.starts.count = 3;
  const FitResult three = fit(*family, captures, options);
  REQUIRE(three.starts.back().status == samara::Termination::failed);
  CHECK_THAT(three.coefficients.at(0).standard_error.value(),
             WithinRel(one.coefficients.at(0).standard_error.value(), 1e-6));
  CHECK(three.join_defect == one.join_defect);
  // The profiles' costs are those of the same joins.
  CHECK_THAT(three.profiles.at(0).interval_upper.value(),
             WithinRel(one.profiles.at(0).interval_upper.value(), 1e-9));
}

TEST_CASE("starts of coefficients fitted in logarithms spread over decades") {
  Linear linear(1e-3);
  linear.options.unknowns.fixed.clear();
  linear.options.unknowns.shared = std::vector<std::string>{"k"};
  linear.options.unknowns.fixed["v(0)"] = 1.2;
  linear.options.unknowns.log_scale = {"k"};
  linear.options.starts.count = 1;
  linear.options.solver.max_iterations = 1;
  linear.options.unknowns.box["k"] = {0.2, 5.0};
  // The centre of [0.2, 5] in logarithms is 1, where x of the captures lies: one step is enough.
  const FitResult result = fit(BrakedFamily(), linear.captures, linear.options);
  CHECK_THAT(result.coefficients.at(0).value, WithinAbs(1.0, 0.01));
}
