#include "samara/identification/prediction_score.h"

#include <cmath>
#include <limits>

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
  const SeenMotion window{kSeen, polynomial(kSeen, a)};
  return (predict(baseline, window, kNext) - polynomial(kNext, a)).cwiseAbs().maxCoeff();
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
  // What follows the end of the window errs less than what is fitted to all of it.
  CHECK(worst(Baseline::constant_velocity, parabola) < worst(Baseline::straight_line, parabola));
  CHECK(worst(Baseline::constant_acceleration, cubic) < worst(Baseline::quadratic, cubic));
}

TEST_CASE("missing values are left out of window and score") {
  SeenMotion window{kSeen, polynomial(kSeen, {0.0, 1.0})};
  window.positions(3, 0) = kNaN;
  Eigen::MatrixXd truth = polynomial(kNext, {0.0, 1.0});
  truth(4, 1) = kNaN;
  const auto distances = prediction_distances(predict(Baseline::straight_line, window, kNext), truth);
  REQUIRE(distances.size() == 9);
  for (const double d : distances) CHECK(d < 1e-12);
  // Two frames make no parabola.
  window.positions.col(0).tail(14).setConstant(kNaN);
  CHECK(predict(Baseline::quadratic, window, kNext).col(0).array().isNaN().all());
  CHECK_FALSE(predict(Baseline::quadratic, window, kNext).col(1).array().isNaN().any());
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

TEST_CASE("distances are those of the plane") {
  Eigen::MatrixXd a(1, 2), b(1, 2);
  a << 1.0, 2.0;
  b << 4.0, 6.0;
  CHECK(prediction_distances(a, b).at(0) == Approx(5.0));
}

TEST_CASE("predictions refuse shapes that do not fit") {
  CHECK_THROWS_AS(predict(Baseline::cubic, {kSeen, Eigen::MatrixXd(3, 2)}, kNext), samara::ArgumentError);
  CHECK_THROWS_AS(prediction_distances(Eigen::MatrixXd(3, 2), Eigen::MatrixXd(3, 1)), samara::ArgumentError);
  CHECK(all_baselines().size() == 5);
  CHECK(to_string(Baseline::constant_velocity) == "constant velocity");
}
