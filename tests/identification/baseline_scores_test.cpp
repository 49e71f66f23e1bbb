#include "samara/identification/forecasts/baseline_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::identification;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// x = sum_k a_k t^k for the first component, and its opposite for the second.
Eigen::MatrixXd polynomial(const Eigen::VectorXd& t, const std::vector<double>& a) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(t.size());
  for (std::size_t k = a.size(); k-- > 0;) x = x.cwiseProduct(t) + Eigen::VectorXd::Constant(t.size(), a[k]);
  Eigen::MatrixXd positions(t.size(), 2);
  positions << x, -x;
  return positions;
}

const Eigen::VectorXd kSeen = Eigen::VectorXd::LinSpaced(16, 0.0, 0.15);
const Eigen::VectorXd kNext = Eigen::VectorXd::LinSpaced(10, 0.16, 0.25);

double worst(Baseline baseline, const std::vector<double>& a) {
  const SeenMotion span{kSeen, polynomial(kSeen, a)};
  return (predict(baseline, span, kNext) - polynomial(kNext, a)).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("each baseline continues the polynomials of its degree exactly, and no others") {
  const std::vector<double> line = {0.1, 2.0}, parabola = {0.1, 2.0, -4.9}, cubic = {0.1, 2.0, -4.9, 30.0};
  for (const Baseline b : {Baseline::straight_line, Baseline::constant_velocity}) {
    CHECK(worst(b, line) < 1e-12);
    CHECK(worst(b, parabola) > 1e-3);
  }
  for (const Baseline b : {Baseline::quadratic, Baseline::constant_acceleration}) {
    CHECK(worst(b, parabola) < 1e-12);
    CHECK(worst(b, cubic) > 1e-3);
  }
  CHECK(worst(Baseline::cubic, cubic) < 1e-11);
  // What follows the end of the span errs less than what is fitted to all of it.
  CHECK(worst(Baseline::constant_velocity, parabola) < worst(Baseline::straight_line, parabola));
  CHECK(worst(Baseline::constant_acceleration, cubic) < worst(Baseline::quadratic, cubic));
}

TEST_CASE("a measured velocity that changes evenly is carried on exactly, from the mean of noisy places") {
  SeenMotion span{kSeen, polynomial(kSeen, {0.1, 2.0, -4.9})};
  CHECK(predict(Baseline::measured_velocity, span, kNext).array().isNaN().all());
  span.rates = span.positions;
  span.rates.col(0) = (2.0 - 9.8 * kSeen.array()).matrix();
  span.rates.col(1) = -span.rates.col(0);
  span.rates(2, 0) = kNaN;
  const Eigen::MatrixXd truth = polynomial(kNext, {0.1, 2.0, -4.9});
  CHECK((predict(Baseline::measured_velocity, span, kNext) - truth).cwiseAbs().maxCoeff() < 1e-12);
  // Noise of a place counts by its mean, 1/16 of one frame's, and by nothing else: a cubic errs by its size.
  span.positions(15, 1) += 0.016;
  const Eigen::MatrixXd off = predict(Baseline::measured_velocity, span, kNext) - truth;
  CHECK((off.col(1).array() - 0.001).abs().maxCoeff() < 1e-12);
  CHECK((predict(Baseline::cubic, span, kNext) - truth).col(1).cwiseAbs().maxCoeff() > 0.016);
}

namespace {

/// About a fixed axis by the angle a_1 t + a_2 t^2.
Eigen::MatrixX4d turns(const Eigen::VectorXd& t, double a_1, double a_2) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  Eigen::MatrixX4d result(t.size(), 4);
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(0.7 + a_1 * t[k] + a_2 * t[k] * t[k], axis));
    result.row(k) << q.w(), q.x(), q.y(), q.z();
  }
  return result;
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

}  // namespace

TEST_CASE("attitudes go on turning about their axis, whatever the signs of their quaternions") {
  SeenTurn span{kSeen, turns(kSeen, 30.0, 20.0)};
  for (Eigen::Index k = 0; k < kSeen.size(); k += 3) span.attitudes.row(k) *= -1.0;
  span.attitudes.row(5).setConstant(kNaN);
  const Eigen::MatrixX4d truth = turns(kNext, 30.0, 20.0);
  CHECK(largest(turn_distances(predict_turn(Baseline::quadratic, span, kNext), truth)) < 1e-9);
  // The line through 0.15 s runs on at the mean rate: at the end it lacks 20 (0.25 - 0.075)^2 rad, and some.
  CHECK(largest(turn_distances(predict_turn(Baseline::straight_line, span, kNext), truth)) > 0.5);
  CHECK(predict_turn(Baseline::measured_velocity, span, kNext).array().isNaN().all());
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  span.body_rates = (30.0 + 40.0 * kSeen.array()).matrix() * axis.transpose();
  CHECK(largest(turn_distances(predict_turn(Baseline::measured_velocity, span, kNext), truth)) < 1e-9);
}

TEST_CASE("missing values are left out of span and score") {
  SeenMotion span{kSeen, polynomial(kSeen, {0.0, 1.0})};
  span.positions(3, 0) = kNaN;
  Eigen::MatrixXd truth = polynomial(kNext, {0.0, 1.0});
  truth(4, 1) = kNaN;
  const auto distances = prediction_distances(predict(Baseline::straight_line, span, kNext), truth);
  REQUIRE(distances.size() == 9);
  for (const double d : distances) CHECK(d < 1e-12);
  // Two frames make no parabola.
  span.positions.col(0).tail(14).setConstant(kNaN);
  CHECK(predict(Baseline::quadratic, span, kNext).col(0).array().isNaN().all());
  CHECK_FALSE(predict(Baseline::quadratic, span, kNext).col(1).array().isNaN().any());
}

TEST_CASE("a tally has median and root mean square over captures") {
  PredictionTally tally("straight line", "position, 0.1 s ahead");
  CHECK(std::isnan(tally.score().median));
  tally.add({3.0, 1.0});
  tally.add({});
  tally.add({2.0, 6.0});
  const PredictionScore score = tally.score();
  CHECK(score.captures == 2);
  CHECK(score.count == 4);
  CHECK(score.median == Approx(2.5));
  CHECK(score.rms == Approx(std::sqrt(50.0 / 4.0)));
  CHECK(score.largest == 6.0);
  CHECK(score.predictor == "straight line");
}

TEST_CASE("tallies of which one was given an empty capture still agree on the captures") {
  PredictionTally one("model", "position"), other("straight line", "position");
  one.add({});
  for (const double distance : {5.0, 7.0}) one.add({distance});
  for (const double distance : {4.0, 5.0, 7.0}) other.add({distance});
  // Of the captures of the first, however they are drawn, both say the same.
  CHECK(one.behind(other).value == 0.0);
  CHECK(one.behind(other).error == 0.0);
  CHECK(other.behind(one).value == 0.0);
}

TEST_CASE("the noise of a point with drag is told only where four frames show all components") {
  SeenMotion span{
      .times = Eigen::VectorXd::LinSpaced(5, 0.0, 0.4), .positions = Eigen::MatrixXd::Ones(5, 3), .up = 2};
  span.positions.col(2) = -4.9 * span.times.array().square();
  CHECK(noise_gain(Baseline::point_with_drag, span, 0.6) > 1.0);
  span.positions(0, 0) = kNaN;
  CHECK(noise_gain(Baseline::point_with_drag, span, 0.6) > 1.0);
  span.positions(1, 1) = kNaN;
  CHECK(std::isnan(noise_gain(Baseline::point_with_drag, span, 0.6)));
  CHECK(predict(Baseline::point_with_drag, span, Eigen::VectorXd::Constant(1, 0.6)).array().isNaN().all());
}

TEST_CASE("distances are those of the plane") {
  Eigen::MatrixXd a(1, 2), b(1, 2);
  a << 1.0, 2.0;
  b << 4.0, 6.0;
  CHECK(prediction_distances(a, b).at(0) == Approx(5.0));
}

TEST_CASE("predictions refuse shapes that do not fit") {
  CHECK_THROWS_AS(predict(Baseline::cubic, {kSeen, Eigen::MatrixXd(3, 2)}, kNext), samara::ArgumentError);
  CHECK_THROWS_AS(prediction_distances(Eigen::MatrixXd(3, 2), Eigen::MatrixXd(3, 1)), samara::ArgumentError);
  const SeenMotion uneven{.times = kSeen,
                          .positions = Eigen::MatrixXd::Ones(kSeen.size(), 3),
                          .rates = Eigen::MatrixXd::Ones(kSeen.size(), 2)};
  CHECK_THROWS_WITH(predict(Baseline::measured_velocity, uneven, kNext),
                    Catch::Contains("rates of 2 components"));
  CHECK_THROWS_AS(noise_gain(Baseline::measured_velocity, uneven, 1.0), samara::ArgumentError);
  CHECK(all_baselines().size() == 7);
  CHECK(to_string(Baseline::constant_velocity) == "constant velocity");
}
