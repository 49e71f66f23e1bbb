#include "samara/identification/forecasts/proper_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/identification/forecasts/forecast_band.h"

using namespace samara::identification;

namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

const NormalMixture kThreeNormals{Eigen::Vector3d(0.5, 0.3, 0.2), Eigen::Vector3d(0.0, 2.0, -1.0),
                                  Eigen::Vector3d(1.0, 0.5, 3.0)};

NormalMixture normal(double mean, double deviation) {
  return {Eigen::VectorXd::Ones(1), Eigen::VectorXd::Constant(1, mean),
          Eigen::VectorXd::Constant(1, deviation)};
}

double drawn_from(const NormalMixture& mixture, samara::Stream& stream) {
  double left = stream.uniform();
  Eigen::Index k = 0;
  while (k + 1 < mixture.weights.size() && left >= mixture.weights[k]) left -= mixture.weights[k++];
  return mixture.means[k] + mixture.deviations[k] * stream.normal();
}

}  // namespace

TEST_CASE("the score of a normal at its mean is its deviation times (sqrt 2 - 1)/sqrt pi") {
  // Gneiting and Raftery, J. Am. Stat. Assoc. 102 (2007) 359, eq. 21, at z = 0.
  const double expected = 2.0 * (std::numbers::sqrt2 - 1.0) / std::sqrt(std::numbers::pi);
  CHECK(crps(normal(3.0, 2.0), 3.0) == Approx(expected).epsilon(1e-13));
  // Split into two alike it is the same forecast.
  const NormalMixture halves{Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(3.0, 3.0), Eigen::Vector2d(2.0, 2.0)};
  CHECK(crps(halves, 4.0) == Approx(crps(normal(3.0, 2.0), 4.0)).epsilon(1e-13));
  // Without spread it is the distance, and far away nearly so: less half the mean distance of two draws.
  CHECK(crps(normal(1.0, 0.0), -2.5) == Approx(3.5).epsilon(1e-15));
  CHECK(crps(normal(0.0, 1.0), 50.0) == Approx(50.0 - 1.0 / std::sqrt(std::numbers::pi)).epsilon(1e-13));
}

TEST_CASE("the score of a mixture is the integral that defines it, and the mean of its draws") {
  for (const double y : {-4.0, 0.3, 2.0, 7.0}) {
    // Simpson's rule to the left and right of the jump.
    const auto half = [&](double from, double to, bool above) {
      constexpr int kSteps = 4000;
      const double h = (to - from) / kSteps;
      double sum = 0.0;
      for (int k = 0; k <= kSteps; ++k) {
        const double F = probability_below(kThreeNormals, from + k * h) - (above ? 1.0 : 0.0);
        sum += (k == 0 || k == kSteps ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) * F * F;
      }
      return sum * h / 3.0;
    };
    CHECK(crps(kThreeNormals, y) == Approx(half(-40.0, y, false) + half(y, 40.0, true)).epsilon(1e-8));
  }
  samara::Stream stream(5, 0);
  constexpr int kDraws = 20000;
  double to_truth = 0.0, among = 0.0;
  for (int k = 0; k < kDraws; ++k) {
    const double x = drawn_from(kThreeNormals, stream);
    to_truth += std::abs(x - 1.2) / kDraws;
    among += std::abs(x - drawn_from(kThreeNormals, stream)) / kDraws;
  }
  // The distances scatter by about 2: three errors of the mean of 20000.
  CHECK(crps(kThreeNormals, 1.2) == Approx(to_truth - 0.5 * among).margin(3.0 * 2.0 / std::sqrt(kDraws)));
}

TEST_CASE("quantiles undo probabilities, and those of a normal are known") {
  CHECK(quantile(normal(1.0, 2.0), 0.95) == Approx(1.0 + 2.0 * 1.6448536269514722).epsilon(1e-12));
  for (const double part : {1e-6, 0.05, 0.25, 0.5, 0.95, 1.0 - 1e-9})
    CHECK(probability_below(kThreeNormals, quantile(kThreeNormals, part)) == Approx(part).epsilon(1e-9));
  CHECK(quantile(normal(4.0, 0.0), 0.3) == Approx(4.0).epsilon(1e-14));
}

TEST_CASE("truths drawn from the forecast lie in its central intervals as often as they should") {
  samara::Stream stream(6, 0);
  ProperScores honest, narrow;
  NormalMixture half = kThreeNormals;
  half.deviations *= 0.3;
  for (int k = 0; k < 4000; ++k) {
    const double y = drawn_from(kThreeNormals, stream);
    honest.add(kThreeNormals, y);
    narrow.add(half, y);
  }
  // Three standard errors of a share of 4000.
  CHECK(honest.coverage(0.5) == Approx(0.5).margin(0.024));
  CHECK(honest.coverage(0.9) == Approx(0.9).margin(0.015));
  CHECK(narrow.coverage(0.9) < 0.75);
  CHECK(std::isnan(honest.coverage_error(0.9)));  // of one cluster
  // Proper: who says what is so has the better score.
  CHECK(honest.mean_crps() < narrow.mean_crps());
  honest.add(kThreeNormals, kNoValue);
  CHECK(honest.count() == 4000);
}

TEST_CASE("a certain forecast lies in every interval where it is right, and in none where it is wrong") {
  ProperScores right, wrong;
  right.add(normal(2.0, 0.0), 2.0);
  wrong.add(normal(2.0, 0.0), 2.5);
  for (const double part : {0.5, 0.9}) {
    CHECK(right.coverage(part) == 1.0);
    CHECK(wrong.coverage(part) == 0.0);
  }
}

TEST_CASE("the error of a coverage is its scatter among draws of motions whose numbers err alike") {
  constexpr int kDraws = 2000, kMotions = 20, kNumbers = 7;
  double sum = 0.0, squares = 0.0, error_squares = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    samara::Stream stream(41, static_cast<std::uint64_t>(draw));
    ProperScores scores;
    for (int motion = 0; motion < kMotions; ++motion) {
      const double common = stream.normal();
      // Of motions seen for as long as they lasted: a different number each.
      for (int k = 0; k < 1 + motion % kNumbers; ++k)
        scores.add(normal(0.0, std::sqrt(1.25)), common + 0.5 * stream.normal(), motion);
    }
    const double coverage = scores.coverage(0.9), error = scores.coverage_error(0.9);
    sum += coverage;
    squares += coverage * coverage;
    error_squares += error * error;
  }
  const double scatter = std::sqrt(squares / kDraws - sum * sum / kDraws / kDraws);
  CHECK(sum / kDraws == Approx(0.9).margin(0.005));
  CHECK(std::sqrt(error_squares / kDraws) == Approx(scatter).epsilon(0.1));
  // As if every number were by itself, it would be far too small.
  CHECK(scatter > 1.5 * std::sqrt(0.9 * 0.1 / (kMotions * (1 + kNumbers) / 2.0)));
}

TEST_CASE("a forecast of several outputs is scored by the mean over what was measured") {
  Forecast forecast{.times = Eigen::Vector2d(0.1, 0.2), .outputs = {"x", "y"}};
  const Eigen::Matrix2d spread = (Eigen::Matrix2d() << 4.0, 1.0, 1.0, 9.0).finished();
  for (const double weight : {0.25, 0.75})
    forecast.components.push_back({weight, Eigen::MatrixXd::Constant(2, 2, weight), {spread, 4.0 * spread}});
  Eigen::MatrixXd measured(2, 2);
  measured << 1.0, 2.0, kNoValue, -3.0;
  ProperScores scores;
  scores.add(forecast, measured);
  CHECK(scores.count() == 3);
  CHECK(std::isnan(scores.coverage_error(0.9)));
  scores.add(forecast, measured, 1);
  CHECK(scores.coverage_error(0.9) == 0.0);  // of two clusters that are alike
  const NormalMixture last = marginal(forecast, 1, 1);
  CHECK(last.weights.isApprox(Eigen::Vector2d(0.25, 0.75)));
  CHECK(last.deviations.isApprox(Eigen::Vector2d(6.0, 6.0)));
  CHECK(scores.each_crps().back() == Approx(crps(last, -3.0)).epsilon(1e-15));
  // One that gives no forecast leaves its weight to the other.
  forecast.components[0].mean(1, 1) = kNoValue;
  CHECK(marginal(forecast, 1, 1).weights.isApprox(Eigen::VectorXd::Ones(1)));
}

TEST_CASE("a certain forecast has a band of no width, and counts beside others") {
  Forecast forecast{.times = Eigen::VectorXd::Ones(1), .outputs = {"x"}};
  forecast.components.push_back({1.0, Eigen::MatrixXd::Constant(1, 1, 2.0), {Eigen::MatrixXd::Zero(1, 1)}});
  const ForecastBand certain = band_of(forecast);
  CHECK(certain.mean(0, 0) == 2.0);
  CHECK(certain.lower(0, 0) == 2.0);
  CHECK(certain.upper(0, 0) == 2.0);
  forecast.components[0].weight = 0.5;
  forecast.components.push_back({0.5, Eigen::MatrixXd::Zero(1, 1), {Eigen::MatrixXd::Ones(1, 1)}});
  const ForecastBand both = band_of(forecast, 0.5);
  CHECK(both.mean(0, 0) == 1.0);
  CHECK(both.lower(0, 0) == Approx(0.0).margin(1e-9));  // a quarter: half of the normal
  CHECK(both.upper(0, 0) == Approx(2.0));               // within the step
  // What is not known stays silent.
  forecast.components[0].covariance[0](0, 0) = kNoValue;
  forecast.components[1].mean(0, 0) = kNoValue;
  CHECK(std::isnan(band_of(forecast).mean(0, 0)));
}

TEST_CASE("forecasts that are none are refused with what is wrong") {
  CHECK_THROWS_WITH(crps(kThreeNormals, kNoValue), Catch::Contains("is nan; a finite one was expected"));
  CHECK_THROWS_WITH(crps(normal(0.0, -1.0), 0.0), Catch::Contains("the deviation -1"));
  CHECK_THROWS_WITH(crps(normal(kNoValue, 1.0), 0.0), Catch::Contains("the mean nan"));
  CHECK_THROWS_WITH(crps({}, 0.0), Catch::Contains("0 weights"));
  NormalMixture heavy = kThreeNormals;
  heavy.weights *= 2.0;
  CHECK_THROWS_WITH(quantile(heavy, 0.5), Catch::Contains("1 was expected"));
  CHECK_THROWS_AS(quantile(kThreeNormals, 1.0), samara::ArgumentError);
  CHECK_THROWS_AS(probability_below(kThreeNormals, kNoValue), samara::ArgumentError);
  Forecast forecast{.times = Eigen::VectorXd::Ones(1), .outputs = {"x"}};
  forecast.components.push_back({1.0, Eigen::MatrixXd::Ones(1, 1), {Eigen::MatrixXd::Constant(1, 1, -1.0)}});
  CHECK_THROWS_WITH(marginal(forecast, 0, 0), Catch::Contains("variance of a forecast is -1"));
  CHECK_THROWS_WITH(marginal(forecast, 1, 0), Catch::Contains("at time 1"));
  ProperScores scores;
  CHECK_THROWS_AS(scores.add(forecast, Eigen::MatrixXd::Ones(2, 1)), samara::ArgumentError);
  CHECK(std::isnan(scores.mean_crps()));
}
