#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/QR>
#include <catch2/catch.hpp>

#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fit_diagnostics.h"
#include "samara/identification/statistics/chains.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;

namespace {

/// Twelve frames with so much noise that what they say of k is skewed.
Capture noisy_capture(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const std::vector<double> times = even_times(12, 1.5);
  Capture capture = make_capture("noisy", times, BrakedFamily::depths(1.4, 1.0, times).array() + 0.2);
  add_noise(capture, 0.01, random);
  return capture;
}

FitOptions asking(int samples) {
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.starts.count = 1;
  options.uncertainty.posterior.samples = samples;
  return options;
}

struct Moments {
  double mean = 0.0, deviation = 0.0;
};

/// Of k in a box: v(0) and the offset, in which the model is linear, integrated out by hand.
Moments exact_moments(const Capture& capture, double lower, double upper, double variance) {
  const std::vector<double> times = even_times(12, 1.5);
  const Eigen::VectorXd& x = capture.channels[0].values;
  double mass = 0.0, first = 0.0, second = 0.0, least = HUGE_VAL;
  std::vector<std::pair<double, double>> logs;
  constexpr int kPoints = 20000;
  for (int i = 0; i < kPoints; ++i) {
    const double k = lower + (upper - lower) * (i + 0.5) / kPoints;
    Eigen::MatrixXd J(12, 2);
    J << BrakedFamily::depths(k, 1.0, times), Eigen::VectorXd::Ones(12);
    const double rest = (x - J * J.colPivHouseholderQr().solve(x)).squaredNorm();
    logs.emplace_back(k, 0.5 * rest / variance + 0.5 * std::log((J.transpose() * J).determinant()));
    least = std::min(least, logs.back().second);
  }
  for (const auto& [k, log] : logs) {
    const double weight = std::exp(least - log);
    mass += weight;
    first += weight * k;
    second += weight * k * k;
  }
  const double mean = first / mass;
  return {mean, std::sqrt(second / mass - mean * mean)};
}

}  // namespace

TEST_CASE(
    "draws of a posterior have the mean and the deviation of the exact one, in the box and at its border") {
  const Capture capture = noisy_capture(3);
  for (const double upper : {5.0, 1.5}) {
    FitOptions options = asking(8000);
    options.unknowns.box["k"] = {0.2, upper};
    const FitResult result = fit(BrakedFamily(), std::vector{capture}, options);
    REQUIRE(result.posterior);
    const Posterior& posterior = *result.posterior;
    CAPTURE(upper, posterior.acceptance, posterior.divergences);
    const PosteriorUnknown& k = posterior.unknowns[0];
    CHECK(k.name == "k");
    CHECK(k.rhat < 1.01);
    CHECK(k.effective > 1000.0);
    CHECK(posterior.draws.rows() == 8000);
    CHECK(posterior.draws.col(0).maxCoeff() <= upper);
    // The noise is what the residuals at the best point show: at a border with one unknown less.
    const double squares = 2.0 * result.cost * std::pow(2e-3, 2);
    const bool at_border = result.coefficients[0].at_bound;
    const Moments exact = exact_moments(capture, 0.2, upper, squares / (at_border ? 10.0 : 9.0));
    const double error = exact.deviation / std::sqrt(k.effective);
    CHECK(std::abs(k.mean - exact.mean) < 5.0 * error);
    CHECK(std::abs(k.deviation - exact.deviation) < 5.0 * error);
    CHECK(k.lower < k.median);
    CHECK(k.median < k.upper);
  }
}

TEST_CASE("a posterior covers the unknowns of each capture, and priors count in it") {
  FitOptions options = asking(4000);
  const Capture capture = noisy_capture(4);
  const FitResult plain = fit(BrakedFamily(), std::vector{capture}, options);
  REQUIRE(plain.posterior->unknowns.size() == 3);
  CHECK(plain.posterior->unknowns[1].name == "noisy: v(0)");
  CHECK(plain.posterior->unknowns[2].name == "noisy: offset of x");
  CHECK(plain.posterior->unknowns[2].median == Approx(0.2).margin(0.05));
  options.priors.coordinates["k"] = {.mean = 1.4, .deviation = 0.01};
  const FitResult known = fit(BrakedFamily(), std::vector{capture}, options);
  CHECK(known.posterior->unknowns[0].deviation == Approx(0.01).epsilon(0.1));
  CHECK(known.posterior->unknowns[0].mean == Approx(1.4).margin(0.005));
}

TEST_CASE("a chain depends on the seed, and on nothing but it") {
  const Capture capture = noisy_capture(5);
  const auto draws = [&](int samples, std::uint64_t seed) {
    FitOptions options = asking(samples);
    options.uncertainty.posterior.seed = seed;
    return fit(BrakedFamily(), std::vector{capture}, options).posterior->draws;
  };
  const Eigen::MatrixXd once = draws(40, 1);
  CHECK(draws(40, 1) == once);
  CHECK(draws(40, 2) != once);
  // The second chain begins with the same draws, however many are asked for.
  CHECK(draws(80, 1).middleRows(20, 10) == once.middleRows(10, 10));
}

TEST_CASE("a posterior of few draws is said not to be settled") {
  const FitResult result = fit(BrakedFamily(), std::vector{noisy_capture(6)}, asking(40));
  CHECK_FALSE(result.posterior->is_settled());
  CHECK_THAT(text_of(result.warnings), Contains("the posterior is not settled"));
}

TEST_CASE("an unknown whose chains never moved is the worst of a posterior") {
  Posterior posterior;
  posterior.unknowns = {{.name = "k", .rhat = 1.2, .effective = 300.0},
                        {.name = "v(0)", .rhat = std::numeric_limits<double>::infinity(), .effective = 0.0},
                        {.name = "x(0)", .rhat = 1.5, .effective = 200.0}};
  CHECK_THAT(describe_unsettled(posterior),
             Contains("R-hat of v(0) is inf") && Contains("v(0) has 0 effective"));
  posterior.unknowns[1].rhat = 1.3;
  CHECK_THAT(describe_unsettled(posterior), Contains("R-hat of x(0) is 1.500"));
}

TEST_CASE("independent draws count for themselves, correlated ones for less, and chains apart are seen") {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd draws(2000, 4);
  for (double& value : draws.reshaped()) value = normal(random);
  const ChainSummary independent = summarize_chains(draws);
  CHECK(independent.rhat == Approx(1.0).margin(0.005));
  CHECK(independent.effective == Approx(8000.0).epsilon(0.15));

  Eigen::MatrixXd slow = draws;
  constexpr double kCorrelation = 0.8;
  for (Eigen::Index k = 1; k < slow.rows(); ++k) {
    slow.row(k) =
        kCorrelation * slow.row(k - 1) + std::sqrt(1.0 - kCorrelation * kCorrelation) * draws.row(k);
  }
  // (1 - r)/(1 + r) of them.
  CHECK(summarize_chains(slow).effective == Approx(8000.0 / 9.0).epsilon(0.2));

  Eigen::MatrixXd apart = draws;
  apart.col(0).array() += 1.0;
  CHECK(summarize_chains(apart).rhat > 1.05);
  Eigen::MatrixXd drifting = draws;
  drifting.colwise() += Eigen::VectorXd::LinSpaced(2000, 0.0, 2.0);
  CHECK(summarize_chains(drifting).rhat > 1.05);
}
