#include "samara/identification/fit/fit_objective.h"

#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "closed_form_family.h"
#include "samara/base/errors.h"
#include "samara/identification/fit/fit.h"
#include "synthetic.h"

using namespace samara::identification;

namespace {

std::vector<Capture> braked_captures() {
  std::mt19937_64 random(4);
  std::vector<Capture> captures;
  for (const double v0 : {0.8, 1.3, 2.0}) {
    const std::vector<double> times = even_times(30, 3.0);
    Eigen::VectorXd x(30);
    for (Eigen::Index i = 0; i < 30; ++i)
      x[i] = 0.1 + v0 * -std::expm1(-1.2 * times[static_cast<std::size_t>(i)]) / 1.2;
    captures.push_back(make_capture("v0 " + std::to_string(v0), times, x));
    add_noise(captures.back(), 5e-3, random);
  }
  captures[1].channels[0].values[7] += 0.2;  // an outlier, beyond the bend of the loss
  return captures;
}

FitOptions with_priors() {
  FitOptions options;
  options.loss.length_scale = 5e-3;
  options.priors.coordinates["k"] = {.mean = 1.0, .deviation = 0.3};
  options.priors.coordinates["v(0)"] = {.mean = 1.5, .deviation = 1.0};
  return options;
}

struct Fitted {
  std::unique_ptr<samara::models::TrajectoryFamily> family;
  std::vector<Capture> captures;
  FitOptions options;
};

/// With a robust loss, an outlier, and priors of shared and own unknowns; and with captures cut into joined segments.
std::vector<Fitted> fits() {
  std::vector<Fitted> all;
  all.push_back({std::make_unique<BrakedFamily>(), braked_captures(), with_priors()});
  std::mt19937_64 random(9);
  std::vector<Capture> coins;
  for (const double v0 : {0.0, 0.2}) {
    coins.push_back(coin_capture("coin " + std::to_string(v0), 1.2, v0, 0.05));
    add_noise(coins.back(), 5e-4, random);
  }
  FitOptions joined;
  joined.segments.length = 0.2;
  joined.starts.count = 1;
  all.push_back({coin_family(), coins, joined});
  all.push_back({std::make_unique<BrakedFamily>(), braked_captures(), with_priors()});
  all.back().options.unknowns.log_scale = {"k"};
  return all;
}

std::span<const double> numbers(const Eigen::VectorXd& q) {
  return {q.data(), static_cast<std::size_t>(q.size())};
}

}  // namespace

TEST_CASE("what a fit minimised is its cost at the answer, where its slope vanishes") {
  for (const Fitted& of : fits()) {
    std::shared_ptr<const FitObjective> objective;
    const FitResult result = fit(*of.family, of.captures, of.options, objective);
    INFO(result.message);
    REQUIRE(result.is_usable());
    REQUIRE(objective);
    const Eigen::VectorXd& q = objective->answer();
    REQUIRE(q.size() == std::ssize(objective->unknowns()));
    CHECK(objective->unknowns()[0].name == result.coefficients[0].name);
    CHECK(q[0] == result.coefficients[0].value);
    Eigen::VectorXd r(objective->residual_count());
    Eigen::MatrixXd J;
    REQUIRE(objective->residuals(numbers(q), r, &J));
    CHECK(0.5 * r.squaredNorm() == Approx(result.cost).epsilon(1e-9));
    const Eigen::VectorXd slope = J.transpose() * r;
    for (Eigen::Index k = 0; k < q.size(); ++k) CHECK(std::abs(slope[k]) < 1e-5 * J.col(k).norm() * r.norm());
  }
}

TEST_CASE("derivatives of the residuals and of the posterior are limits of central differences") {
  for (const Fitted& of : fits()) {
    std::shared_ptr<const FitObjective> objective;
    fit(*of.family, of.captures, of.options, objective);
    REQUIRE(objective);
    const Eigen::VectorXd q = objective->answer() * 1.01;
    const Eigen::Index rows = objective->residual_count();
    Eigen::VectorXd r(rows), above(rows), below(rows), gradient;
    Eigen::MatrixXd J;
    REQUIRE(objective->residuals(numbers(q), r, &J));
    const double here = objective->log_posterior(numbers(q), &gradient);
    CHECK(here < objective->log_posterior(numbers(objective->answer())));
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      const double h = 1e-6;
      const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(q.size(), k);
      REQUIRE(objective->residuals(numbers(q + step), above));
      REQUIRE(objective->residuals(numbers(q - step), below));
      // Third derivatives times h^2, and rounding of residuals of 10 over h.
      CHECK((J.col(k) - (above - below) / (2.0 * h)).cwiseAbs().maxCoeff() < 1e-6 * (1.0 + J.col(k).norm()));
      const double slope =
          (objective->log_posterior(numbers(q + step)) - objective->log_posterior(numbers(q - step))) /
          (2.0 * h);
      CHECK(gradient[k] == Approx(slope).epsilon(1e-5).margin(1e-4 * std::abs(here)));
    }
  }
}

TEST_CASE("a point outside the box has no density, and one of another size is refused") {
  const BrakedFamily family;
  std::shared_ptr<const FitObjective> objective;
  fit(family, braked_captures(), with_priors(), objective);
  REQUIRE(objective);
  Eigen::VectorXd q = objective->answer();
  q[0] = 7.0;
  CHECK(objective->log_posterior(numbers(q)) == -std::numeric_limits<double>::infinity());
  q[0] = std::nan("");
  CHECK_THROWS_AS(objective->log_posterior(numbers(q)), samara::ArgumentError);
  Eigen::VectorXd r(objective->residual_count());
  CHECK_THROWS_AS(objective->residuals(numbers(q.head(2)), r), samara::ArgumentError);
  CHECK_THROWS_AS(objective->residuals(numbers(objective->answer()), r.head(3)), samara::ArgumentError);
}

TEST_CASE("the density of a point is the same with its gradient, also where that is not finite") {
  const ClosedFormFamily family = roots(0.5, 0.0);
  const std::vector<double> times = even_times(5, 1.0);
  Eigen::VectorXd x(5);
  for (Eigen::Index k = 0; k < 5; ++k)
    x[k] = std::sqrt(1.0 + times[static_cast<std::size_t>(k)]) + (k % 2 == 0 ? 0.01 : -0.01);
  FitOptions options;
  options.starts.count = 1;
  std::shared_ptr<const FitObjective> objective;
  fit(family, std::vector{make_capture("a", times, x)}, options, objective);
  REQUIRE(objective);
  REQUIRE(objective->unknowns()[1].name == "a: v0");
  Eigen::VectorXd q = objective->answer(), gradient;
  q[1] = 0.0;  // where the root begins at t = 0
  const double value = objective->log_posterior(numbers(q));
  CHECK(std::isfinite(value));
  CHECK(objective->log_posterior(numbers(q), &gradient) == value);
  CHECK_FALSE(gradient.allFinite());
  Eigen::VectorXd r(objective->residual_count()), with_slopes = r;
  Eigen::MatrixXd J;
  REQUIRE(objective->residuals(numbers(q), r));
  REQUIRE(objective->residuals(numbers(q), with_slopes, &J));
  CHECK(with_slopes == r);
  CHECK_FALSE(J.row(0).allFinite());
  CHECK(J.bottomRows(4).allFinite());

  q[0] = -1.0;  // a root of negative numbers
  CHECK_FALSE(objective->residuals(numbers(q), r));
  CHECK_FALSE(objective->residuals(numbers(q), r, &J));
}
