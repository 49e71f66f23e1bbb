/// The evidence of models against integrals that are known, or done on a grid.
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "closed_form_family.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/forecast_comparison.h"
#include "synthetic.h"

using namespace samara::identification;
using samara::Outcome;

namespace {

constexpr double kLossScale = 2e-3;  ///< m, of the loss
const double kNoiseRange = std::log(1e3);

/// ln of the sum of exponentials of equal steps.
double log_sum(const std::vector<double>& logs, double step) {
  const double most = *std::ranges::max_element(logs);
  double sum = 0.0;
  for (const double one : logs) sum += std::exp(one - most);
  return most + std::log(sum * step);
}

/// x = a + b t, with boxes far from what captures say.
ClosedFormFamily line(bool with_slope) {
  samara::models::FamilyInfo info;
  info.model = "line";
  info.coordinates = {{"a", "m", false, -100.0, 100.0}};
  if (with_slope) info.coordinates.push_back({"b", "m/s", false, -100.0, 100.0});
  info.outputs = {{"x", "m"}};
  return {info, [with_slope](std::span<const double> q, double t, Eigen::RowVectorXd& values,
                             Eigen::RowVectorXd* derivatives) {
            values[0] = q[0] + (with_slope ? q[1] * t : 0.0);
            if (!derivatives) return;
            (*derivatives)[0] = 1.0;
            if (with_slope) (*derivatives)[1] = t;
          }};
}

FitOptions plain_options() {
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.loss.length_scale = kLossScale;
  options.starts.count = 1;
  return options;
}

Outcome<Evidence> evidence_of(const samara::models::TrajectoryFamily& family,
                              const std::vector<Capture>& captures, const FitOptions& options) {
  std::shared_ptr<const FitObjective> objective;
  fit(family, captures, options, objective);
  REQUIRE(objective);
  return objective->evidence();
}

/// ln of the density of normal data with normal priors, integrated over the logarithm of the noise on a grid.
double exact_of_line(const Eigen::VectorXd& times, const Eigen::VectorXd& x, const Eigen::Vector2d& mean,
                     const Eigen::Vector2d& deviation, bool with_slope) {
  Eigen::MatrixXd design(times.size(), with_slope ? 2 : 1);
  design.col(0).setOnes();
  if (with_slope) design.col(1) = times;
  const Eigen::Index d = design.cols();
  const Eigen::VectorXd miss = x - design * mean.head(d);
  const Eigen::MatrixXd spread = design * deviation.head(d).cwiseAbs2().asDiagonal() * design.transpose();
  constexpr double kStep = 5e-3;
  std::vector<double> logs;
  for (double l = -kNoiseRange; l < kNoiseRange; l += kStep) {
    Eigen::MatrixXd covariance = spread;
    covariance.diagonal().array() += std::pow(kLossScale * std::exp(l), 2);
    const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
    const double log_det = 2.0 * llt.matrixLLT().diagonal().array().log().sum();
    logs.push_back(-0.5 * (miss.dot(llt.solve(miss)) + log_det +
                           static_cast<double>(x.size()) * std::log(2.0 * std::numbers::pi)));
  }
  return log_sum(logs, kStep) - std::log(2.0 * kNoiseRange);
}

}  // namespace

TEST_CASE("of normal data and normal priors the evidence is that of the closed form") {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 3e-3);
  const std::vector<double> times = even_times(60, 1.0);
  const Eigen::VectorXd t = Eigen::Map<const Eigen::VectorXd>(times.data(), 60);
  const Eigen::Vector2d mean(0.1, 0.0), deviation(0.05, 0.02);
  // Normal in d unknowns; with the noise their density is Student's, which the method misses by (d + 1)^2/(4 N).
  const auto left_by_laplace = [](int unknowns) { return 1.3 * std::pow(unknowns + 1, 2) / (4.0 * 60.0); };
  for (const double slope : {0.0, 0.012}) {
    Eigen::VectorXd x = 0.12 + slope * t.array();
    for (double& one : x) one += noise(random);
    const std::vector<Capture> captures = {make_capture("a", times, x)};
    double difference = 0.0, exact_difference = 0.0;
    for (const bool with_slope : {false, true}) {
      FitOptions options = plain_options();
      options.priors.coordinates["a"] = {.mean = mean[0], .deviation = deviation[0]};
      if (with_slope) options.priors.coordinates["b"] = {.mean = mean[1], .deviation = deviation[1]};
      const ClosedFormFamily family = line(with_slope);
      const Outcome<Evidence> evidence = evidence_of(family, captures, options);
      REQUIRE(evidence);
      const double exact = exact_of_line(t, x, mean, deviation, with_slope);
      CHECK(evidence->log == Approx(exact).margin(left_by_laplace(with_slope ? 2 : 1)));
      CHECK(evidence->values == 60);
      CHECK(evidence->unknowns == (with_slope ? 2 : 1));
      if (with_slope || slope == 0.0) CHECK(evidence->noise_factor == Approx(1.5).epsilon(0.3));
      difference += with_slope ? evidence->log : -evidence->log;
      exact_difference += with_slope ? exact : -exact;
    }
    CHECK(difference == Approx(exact_difference).margin(left_by_laplace(2)));
    // A slope that is not there costs what its prior spent beside the truth; one that is there pays.
    CHECK((difference > 0.0) == (slope > 0.0));
  }
}

TEST_CASE("of a braked motion the evidence is the integral over the box") {
  std::mt19937_64 random(6);
  const std::vector<double> times = even_times(40, 1.5);
  std::vector<Capture> captures = {make_capture("a", times, BrakedFamily::depths(1.4, 0.9, times))};
  add_noise(captures[0], 3e-3, random);
  FitOptions options = plain_options();
  options.unknowns.shared = {"v(0)"};
  options.unknowns.offsets = std::vector<std::string>{};
  const BrakedFamily family;
  const Outcome<Evidence> evidence = evidence_of(family, captures, options);
  REQUIRE(evidence);

  // Over the noise in closed form: of exp(-N l - C exp(-2 l)) that is Gamma(N/2)/(2 C^(N/2)).
  const Eigen::VectorXd& x = captures[0].channels[0].values;
  const auto n = static_cast<double>(x.size());
  constexpr int kCells = 400;
  constexpr double kLow = 1.1, kHigh = 1.7, kSlow = 0.8, kFast = 1.0;  // beyond them nothing is left
  std::vector<double> logs;
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      const double k = kLow + (kHigh - kLow) * (i + 0.5) / kCells;
      const double v = kSlow + (kFast - kSlow) * (j + 0.5) / kCells;
      const double cost = 0.5 * ((x - BrakedFamily::depths(k, v, times)) / kLossScale).squaredNorm();
      logs.push_back(std::lgamma(0.5 * n) - std::log(2.0) - 0.5 * n * std::log(cost));
    }
  }
  const double cell = (kHigh - kLow) * (kFast - kSlow) / (kCells * kCells);
  const double exact = log_sum(logs, cell) - n * std::log(kLossScale * std::sqrt(2.0 * std::numbers::pi)) -
                       std::log(2.0 * kNoiseRange) - std::log((5.0 - 0.2) * (3.0 - 0.2));
  CHECK(evidence->log ==
        Approx(exact).margin(0.1));  // d (d + 2)/(2 N) for a t distribution in place of a normal one
}

TEST_CASE("with an outlier a loss that bends finds the captures likelier than one that does not") {
  std::mt19937_64 random(7);
  const std::vector<double> times = even_times(60, 1.0);
  std::vector<Capture> captures = {make_capture("a", times, Eigen::VectorXd::Constant(60, 0.12))};
  add_noise(captures[0], kLossScale, random);
  captures[0].channels[0].values[20] += 20.0 * kLossScale;
  const ClosedFormFamily family = line(false);
  FitOptions options = plain_options();
  options.unknowns.box["a"] = {0.0, 1.0};
  const double straight = evidence_of(family, captures, options)->log;
  options.loss.kind = LossKind::huber;
  CHECK(evidence_of(family, captures, options)->log > straight + 5.0);
}

TEST_CASE("where a prior is none, or the answer lies at a wall, there is no evidence, and it is said why") {
  std::mt19937_64 random(8);
  const std::vector<double> times = even_times(40, 1.5);
  std::vector<Capture> captures = {make_capture("a", times, BrakedFamily::depths(1.4, 0.9, times))};
  add_noise(captures[0], 3e-3, random);
  const BrakedFamily family;
  FitOptions options = plain_options();
  options.unknowns.shared = {"v(0)"};
  const auto reason = [&] {
    const Outcome<Evidence> evidence = evidence_of(family, captures, options);
    REQUIRE_FALSE(evidence);
    return evidence.ending().message;
  };
  CHECK_THAT(reason(), Catch::Contains("offset of x"));
  options.unknowns.offsets = std::vector<std::string>{};
  options.unknowns.box["k"] = {0.2, 1.4};
  CHECK_THAT(reason(), Catch::Contains("k lies within two deviations"));
  options.unknowns.box.clear();
  options.loss.kind = LossKind::cauchy;
  CHECK_THAT(reason(), Catch::Contains("\"cauchy\" is no density"));
  options.loss.kind = LossKind::none;
  options.priors.combinations = {{.weights = {{"k", 1.0}, {"v(0)", 1.0}}, .mean = 2.3, .deviation = 0.1}};
  CHECK_THAT(reason(), Catch::Contains("several unknowns together"));

  // Of other values than the first nothing is said: other numbers of them, other outputs, other captures.
  const auto of = [](double log, int values, const std::string& output, const std::string& capture) {
    return Evidence{.log = log,
                    .values = values,
                    .compared = {.outputs = {output}, .captures = {{"drops.csv", capture}}}};
  };
  const std::vector<ComparedModel> models = {
      {.name = "a", .evidence = of(3.0, 40, "x", "1")}, {.name = "b", .evidence = of(5.0, 40, "x", "1")},
      {.name = "c", .evidence = of(5.0, 39, "x", "1")}, {.name = "d", .evidence = of(5.0, 40, "z", "1")},
      {.name = "e", .evidence = of(5.0, 40, "x", "2")}, {.name = "f", .no_evidence = "none"}};
  CHECK(evidence_to_first(models, 1) == Approx(2.0));
  for (std::size_t other = 2; other < models.size(); ++other) CHECK_FALSE(evidence_to_first(models, other));
}

TEST_CASE("with an unknown of its own for each capture the evidence is the product over them") {
  // Of each capture its own place, integrated in closed form: given the noise captures are independent, so that their
  // densities multiply. The noise, which they share, on a grid.
  std::mt19937_64 random(9);
  const std::vector<double> times = even_times(60, 1.0);
  const double mean = 0.1, deviation = 0.05;
  std::vector<Capture> captures;
  for (const double place : {0.07, 0.16}) {
    captures.push_back(
        make_capture(place < 0.1 ? "low" : "high", times, Eigen::VectorXd::Constant(60, place)));
    add_noise(captures.back(), 3e-3, random);
  }
  samara::models::FamilyInfo info;
  info.model = "place";
  info.coordinates = {{"x(0)", "m", true, -100.0, 100.0}};
  info.outputs = {{"x", "m"}};
  const ClosedFormFamily family(info, [](std::span<const double> q, double, Eigen::RowVectorXd& values,
                                         Eigen::RowVectorXd* derivatives) {
    values[0] = q[0];
    if (derivatives) (*derivatives)[0] = 1.0;
  });
  FitOptions options = plain_options();
  options.priors.coordinates["x(0)"] = {.mean = mean, .deviation = deviation};
  const Outcome<Evidence> evidence = evidence_of(family, captures, options);
  REQUIRE(evidence);
  CHECK(evidence->unknowns == 2);
  CHECK(evidence->values == 120);
  CHECK(evidence->compared.outputs == std::vector<std::string>{"x"});
  CHECK(evidence->compared.captures.size() == 2);

  constexpr double kStep = 5e-3;
  std::vector<double> logs;
  for (double l = -kNoiseRange; l < kNoiseRange; l += kStep) {
    const double noise = kLossScale * std::exp(l);
    double sum = 0.0;
    for (const Capture& capture : captures) {
      // Of a mean of 60 values and what these scatter about it.
      const Eigen::VectorXd& x = capture.channels[0].values;
      const double middle = x.mean(), spread = deviation * deviation + noise * noise / 60.0;
      sum += -0.5 * (x.array() - middle).square().sum() / (noise * noise) -
             59.0 * std::log(noise * std::sqrt(2.0 * std::numbers::pi)) - 0.5 * std::log(60.0) -
             0.5 * std::pow(middle - mean, 2) / spread - 0.5 * std::log(2.0 * std::numbers::pi * spread);
    }
    logs.push_back(sum);
  }
  const double exact = log_sum(logs, kStep) - std::log(2.0 * kNoiseRange);
  // Missed as above: (d + 1)^2/(4 N).
  CHECK(evidence->log == Approx(exact).margin(1.3 * 9.0 / (4.0 * 120.0)));
}

namespace {

/// x = a with derivatives that are a multiple of those it has: Newton's step is too short, too long, or backwards.
ClosedFormFamily of_wrong_slope(double multiple, double defined_below) {
  samara::models::FamilyInfo info;
  info.model = "place";
  info.coordinates = {{"a", "m", false, -100.0, 100.0}};
  info.outputs = {{"x", "m"}};
  return {info, [multiple, defined_below](std::span<const double> q, double, Eigen::RowVectorXd& values,
                                          Eigen::RowVectorXd* derivatives) {
            values[0] = q[0] < defined_below ? q[0] : std::nan("");
            if (derivatives) (*derivatives)[0] = multiple;
          }};
}

}  // namespace

TEST_CASE("where the minimum is not found there is no evidence") {
  std::mt19937_64 random(10);
  const std::vector<double> times = even_times(60, 1.0);
  std::vector<Capture> captures = {make_capture("a", times, Eigen::VectorXd::Constant(60, 0.12))};
  add_noise(captures[0], kLossScale, random);
  FitOptions options = plain_options();
  options.starts.initial["a"] = 0.1215;  // six errors off
  for (const double multiple : {-1.0, 100.0}) {
    CAPTURE(multiple);
    options.solver.max_iterations = 1;
    const Outcome<Evidence> evidence = evidence_of(of_wrong_slope(multiple, 200.0), captures, options);
    REQUIRE_FALSE(evidence);
    CHECK_THAT(evidence.ending().message, Catch::Contains("the minimum was not found"));
  }
  // A step too long by 1/0.6, to where there is no trajectory, is halved.
  const Outcome<Evidence> right = evidence_of(of_wrong_slope(1.0, 200.0), captures, options);
  options.starts.initial["a"] = 0.0;
  const Outcome<Evidence> walled = evidence_of(of_wrong_slope(0.6, 0.19), captures, options);
  REQUIRE(right);
  REQUIRE(walled);
  // The curvature is 0.36 of what it is.
  CHECK(walled->log == Approx(right->log - std::log(0.6)).margin(1e-3));
}
