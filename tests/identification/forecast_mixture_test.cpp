#include "samara/identification/forecasts/forecast_mixture.h"

#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/base/streams.h"

using namespace samara::identification;

namespace {

constexpr double kSilence = std::numeric_limits<double>::quiet_NaN();
const Components kTwoLevel = {.level = {0, 1}};

}  // namespace

TEST_CASE("shares of predictors are those with which the truth was mixed") {
  samara::Stream stream(1, 0);
  std::vector<Eigen::MatrixXd> said(3, Eigen::MatrixXd(200, 2));
  for (Eigen::MatrixXd& one : said) one = one.unaryExpr([&](double) { return stream.normal(); });
  Eigen::MatrixXd truth = 0.3 * said[0] + 0.7 * said[2];
  truth(7, 0) = 1e3;  // one wild frame
  said[1].row(9).setConstant(kSilence);
  const Eigen::VectorXd shares = convex_shares(said, truth);
  CHECK(shares.isApprox(Eigen::Vector3d(0.3, 0.0, 0.7), 1e-2));
  CHECK(shares.sum() == Approx(1.0).epsilon(1e-12));
  CHECK(shares.minCoeff() >= 0.0);
  // One that gives no forecast leaves its share to the others.
  said[0].row(3).setConstant(kSilence);
  CHECK(weighted(said, shares).row(3).isApprox(said[2].row(3), 1e-2));
  CHECK_THROWS_AS(convex_shares({}, truth), samara::ArgumentError);
  CHECK_THROWS_AS(convex_shares(std::span(said).first(2), truth.topRows(5)), samara::ArgumentError);
}

TEST_CASE("errors of two sizes come back as two normals, and grow with the signs they grew with") {
  samara::Stream stream(2, 0);
  Eigen::MatrixXd errors(4000, 3);
  Eigen::MatrixXd signs(errors.rows(), 2);
  for (Eigen::Index k = 0; k < errors.rows(); ++k) {
    for (Eigen::Index j = 0; j < 2; ++j) signs(k, j) = stream.uniform() < 0.5 ? -1.0 : 1.0;
    for (Eigen::Index c = 0; c < 3; ++c)
      errors(k, c) = stream.normal() * (stream.uniform() < 0.8 ? 1.0 : 4.0) + (c == 2 ? 0.5 : 0.0);
  }
  const auto plain = ErrorDistribution::fit(errors, kTwoLevel);
  const NormalMixture level = plain.around(1, 10.0), up = plain.around(2, 10.0);
  CHECK(level.weights.isApprox(Eigen::Vector2d(0.8, 0.2), 0.05));
  CHECK(level.deviations.isApprox(Eigen::Vector2d(1.0, 4.0), 0.05));
  CHECK(level.means.isApprox(Eigen::Vector2d(10.0, 10.0)));
  CHECK(up.means[0] == Approx(10.5).margin(0.1));
  const Eigen::MatrixXd growing = (0.5 * signs.col(1)).array().exp().matrix().asDiagonal() * errors;
  const auto with = ErrorDistribution::fit(growing, kTwoLevel, signs);
  const auto deviation = [&](double first, double second) {
    return with.around(0, 0.0, Eigen::RowVector2d(first, second)).deviations[0];
  };
  CHECK(deviation(1.0, 1.0) / deviation(1.0, -1.0) == Approx(std::exp(1.0)).epsilon(0.1));
  CHECK(deviation(1.0, 1.0) / deviation(-1.0, 1.0) == Approx(1.0).epsilon(0.1));
  // What training did not see counts as the ends of what it saw; the unknown as its mean.
  CHECK(deviation(1.0, 50.0) == deviation(1.0, 1.0));
  const double unknown = deviation(kSilence, kSilence);
  CHECK(unknown / deviation(0.0, -1.0) == Approx(std::exp(0.5)).epsilon(0.1));
  CHECK(with.around(0, 0.0).deviations[0] == unknown);
  // Two motions tell little of what errors grow with.
  std::vector<int> of_two(4000);
  for (std::size_t k = 0; k < of_two.size(); ++k) of_two[k] = k < 2000 ? 0 : 1;
  const auto unsure = ErrorDistribution::fit(growing, kTwoLevel, signs, of_two);
  CHECK(unsure.around(0, 0.0, Eigen::RowVector2d(1.0, 1.0)).deviations[0] <
        1.5 * unsure.around(0, 0.0, Eigen::RowVector2d(1.0, -1.0)).deviations[0]);
  CHECK_THROWS_AS(with.around(0, 0.0, Eigen::RowVector3d::Zero()), samara::ArgumentError);
  CHECK_FALSE(ErrorDistribution::fit(errors.topRows(2), kTwoLevel).is_fitted());
  CHECK_THROWS_AS(ErrorDistribution::fit(errors, kTwoLevel, signs.topRows(3)), samara::ArgumentError);
}

TEST_CASE("errors of few motions are as much wider as the 90 % band of Student's distribution is") {
  samara::Stream stream(3, 0);
  Eigen::MatrixXd errors(4000, 2);
  errors = errors.unaryExpr([&](double) { return stream.normal(); });
  const auto deviation = [&](std::size_t motions) {
    std::vector<int> clusters(4000);
    for (std::size_t k = 0; k < clusters.size(); ++k) clusters[k] = static_cast<int>(k % motions);
    return ErrorDistribution::fit(errors, kTwoLevel, {}, clusters).around(0, 0.0).deviations[0];
  };
  // Quantiles at 95 % by degrees of freedom: M. Abramowitz, I. Stegun, Handbook of Mathematical Functions, table 26.10.
  const std::vector<std::pair<std::size_t, double>> quantiles = {
      {1, 6.314}, {2, 2.920}, {3, 2.353}, {4, 2.132}, {5, 2.015}, {6, 1.943}, {10, 1.812}, {30, 1.697}};
  constexpr double kOfAll = 1.6452;  // 3999 degrees of freedom
  for (const auto& [freedom, quantile] : quantiles)
    CHECK(kOfAll * deviation(freedom + 1) / deviation(4000) == Approx(quantile).margin(6e-4));
  CHECK(deviation(1) == deviation(2));
}
