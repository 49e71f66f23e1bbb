#include "samara/identification/statistics/whiteness.h"

#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;

namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr int kSeeds = 2000;

/// Each e_k = a e_(k-1) + noise, of variance 1.
std::vector<double> series(int count, double a, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<double> values;
  double last = normal(random);
  for (int k = 0; k < count; ++k) {
    values.push_back(last);
    last = a * last + std::sqrt(1.0 - a * a) * normal(random);
  }
  return values;
}

/// Part of the series that are rejected at 5 %; about a `missing` part of the frames is not there.
double rejections(int count, double a, double missing = 0.0) {
  std::mt19937_64 random(7);
  const std::vector<double> times = even_times(count, 1.0);
  std::bernoulli_distribution gap(missing);
  int rejected = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::vector<double> values = series(count, a, random);
    for (double& value : values) value = gap(random) ? kMissing : value;
    rejected += series_whiteness(times, values).p_value.value() < 0.05 ? 1 : 0;
  }
  return static_cast<double>(rejected) / kSeeds;
}

}  // namespace

TEST_CASE("independent residuals are rejected in about 5 % of the cases, with gaps as well") {
  // 2000 seeds: a standard deviation of 0.5 %. The statistic is chi2 only approximately; Ljung and Box's own
  // table has 4 to 6 % for series of this length.
  for (const int count : {25, 60, 200}) {
    INFO(count);
    CHECK(rejections(count, 0.0) == Approx(0.05).margin(0.02));
  }
  CHECK(rejections(100, 0.0, 0.3) == Approx(0.05).margin(0.02));
}

TEST_CASE("a correlation of 0.3 between neighbours is found") {
  // r_1 = 0.3 in 200 residuals stands 4.2 standard deviations off; spread over K = 10 lags it is seen in most
  // cases.
  CHECK(rejections(200, 0.3) > 0.85);
  CHECK(rejections(100, 0.3) > 0.5);
  CHECK(rejections(200, 0.3, 0.2) > 0.6);
  CHECK(rejections(60, 0.8) > 0.98);
}

TEST_CASE("without gaps the statistic is that of Ljung and Box") {
  const std::vector<double> e = {0.3, -0.2, 0.5, 0.1, -0.4, 0.2, -0.1, 0.6, -0.3, 0.2};
  double squares = 0.0;
  for (const double value : e) squares += value * value;
  double expected = 0.0;
  for (std::size_t k = 1; k <= 2; ++k) {
    double product = 0.0;
    for (std::size_t i = 0; i + k < e.size(); ++i) product += e[i] * e[i + k];
    expected += 10.0 * 12.0 * std::pow(product / squares, 2) / (10.0 - static_cast<double>(k));
  }
  const SeriesWhiteness w = series_whiteness(even_times(10, 1.0), e);
  CHECK(w.lags == 2);
  CHECK(w.statistic == Approx(expected));
  CHECK(w.count == 10);
}

TEST_CASE("no pair reaches over a gap") {
  // Neighbours are opposite, and so they are counted, but for the two on either side of dropped frames.
  std::vector<double> times, values;
  for (int k = 0; k < 20; ++k) {
    times.push_back(0.01 * (k < 10 ? k : k + 3));
    values.push_back(k % 2 == 0 ? 1.0 : -1.0);
  }
  const SeriesWhiteness w = series_whiteness(times, values);
  CHECK(w.lag1 == Approx(-1.0));
}

TEST_CASE("outliers neither make nor hide correlation") {
  std::mt19937_64 random(3);
  std::vector<double> values = series(200, 0.6, random);
  const std::vector<double> times = even_times(200, 1.0);
  const double before = series_whiteness(times, values).lag1;
  for (const std::size_t k : {20U, 90U, 150U}) values[k] = 100.0;
  CHECK(series_whiteness(times, values).lag1 == Approx(before).margin(0.15));
}

TEST_CASE("the size of residuals tells nothing of their correlation") {
  std::vector<double> values = {1.0, -0.3, 0.8,  0.2, -1.4, 0.5, 0.1, -0.7,
                                1.2, 0.4,  -0.2, 0.9, -1.1, 0.6, 0.3};
  std::vector<double> times;
  for (std::size_t k = 0; k < values.size(); ++k) times.push_back(0.1 * static_cast<double>(k));
  const auto w = series_whiteness(times, values);
  REQUIRE(w.p_value);
  for (const int exponent : {-900, 900}) {
    std::vector<double> scaled;
    for (const double value : values) scaled.push_back(std::ldexp(value, exponent));
    CHECK(series_whiteness(times, scaled).p_value == w.p_value);
    CHECK(series_whiteness(times, scaled).lag1 == w.lag1);
  }
}

TEST_CASE("few, missing or zero residuals have no p-value") {
  CHECK_FALSE(series_whiteness(even_times(7, 1.0), std::vector<double>(7, 0.1)).p_value);
  CHECK_FALSE(series_whiteness(even_times(20, 1.0), std::vector<double>(20, kMissing)).p_value);
  CHECK_FALSE(series_whiteness(even_times(20, 1.0), std::vector<double>(20, 0.0)).p_value);
  CHECK_FALSE(series_whiteness({}, {}).p_value);
  CHECK_THAT(pool_whiteness({}).sentence, Contains("too few"));
}

TEST_CASE("the pooled sentence says what to make of it") {
  std::mt19937_64 random(5);
  const std::vector<double> times = even_times(100, 1.0);
  std::vector<SeriesWhiteness> white, red;
  for (int c = 0; c < 20; ++c) {
    white.push_back(series_whiteness(times, series(100, 0.0, random)));
    red.push_back(series_whiteness(times, series(100, 0.6, random)));
  }
  const Whiteness chance = pool_whiteness(white);
  CHECK(chance.tested == 20);
  CHECK(chance.rejected <= 4);
  CHECK_THAT(chance.sentence, Contains("as chance has it"));
  const Whiteness left = pool_whiteness(red);
  CHECK(left.rejected == 20);
  CHECK(*left.p_value < 1e-10);
  // sqrt(1.6/0.4) = 2.
  CHECK(left.median_lag1 == Approx(0.6).margin(0.06));
  CHECK_THAT(left.sentence, Contains("naive errors are too small by a factor of about"));
}

TEST_CASE("residuals without matching times, or with times that go back, are refused") {
  CHECK_THROWS_AS(series_whiteness(even_times(5, 1.0), std::vector<double>(4, 0.0)), samara::ArgumentError);
  CHECK_THROWS_AS(series_whiteness(std::vector<double>{0.1, 0.0}, std::vector<double>{1.0, 1.0}),
                  samara::ArgumentError);
  CHECK_THROWS_AS(series_whiteness(even_times(5, 1.0), std::vector<double>(5, 0.0), -1),
                  samara::ArgumentError);
}
