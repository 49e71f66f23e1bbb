/// What is said of coefficients where the fit knows that a plain error would mislead.
#include <algorithm>

#include <catch2/catch.hpp>

#include "closed_form_family.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/report/fit_report.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;

namespace {

/// x = p^2 t + a p t^2: much the same path for p and -p where a is small.
class TwoValleys final : public ClosedFormFamily {
 public:
  explicit TwoValleys(double bend)
      : ClosedFormFamily(
            {.model = "two valleys", .coordinates = {{"p", "1", false, -2.0, 2.1}}, .outputs = {{"x", "m"}}},
            [bend](std::span<const double> q, double t, auto& values, auto* derivatives) {
              values << q[0] * q[0] * t + bend * q[0] * t * t;
              if (derivatives) *derivatives << 2.0 * q[0] * t + bend * t * t;
            }) {}
};

std::vector<Capture> valley_captures(double bend, double scatter, std::uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const std::vector<double> times = even_times(9, 1.0);
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(9, 0.0, 1.0);
  std::vector<Capture> captures;
  for (int c = 0; c < count; ++c) {
    // Each capture bends by itself, far more than the sides of the valley differ.
    const double own = bend + scatter * normal(random);
    captures.push_back(make_capture(fmt::format("{}", c), times, (t + own * t * t).matrix()));
    add_noise(captures.back(), 1e-3, random);
  }
  return captures;
}

FitResult valley_fit(double bend, const std::vector<Capture>& captures) {
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.starts.count = 6;
  return fit(TwoValleys(bend), captures, options);
}

}  // namespace

TEST_CASE("an optimum that the captures cannot tell from the answer stands in the verdict") {
  const FitResult result = valley_fit(0.02, valley_captures(0.02, 0.1, 1, 8));
  REQUIRE(result.other_optima.size() == 1);
  const Coefficient& p = result.coefficients[0];
  CHECK(p.value * result.other_optima[0].coefficients[0] < 0.0);
  CHECK_THAT(verdict(result, p), Contains(" +- ") && Contains(" or "));
  CHECK_THAT(text_of(result.warnings),
             Contains("do not distinguish the answer from another optimum") && Contains("between clusters"));
  CHECK_THAT(fit_json(result), Contains("\"other_optima\": [\n    {"));
}

TEST_CASE("an optimum that the captures exclude does not") {
  const FitResult result = valley_fit(0.2, valley_captures(0.2, 0.01, 1, 8));
  CHECK(result.starts_at_best < 6);
  CHECK(result.other_optima.empty());
  CHECK_THAT(verdict(result, result.coefficients[0]), !Contains(" or "));
  CHECK_THAT(result.coefficients[0].value, WithinAbs(1.0, 0.02));
}

TEST_CASE("an optimum that every capture is against, and one by far, is excluded") {
  // Costs of the other valley, p = -1.095, by minimizing over p: more by 570 to 620 for each of the short captures,
  // and by 37500 for the long one. Their scatter, 36900, is nearly the excess.
  std::mt19937_64 random(1);
  std::vector<Capture> captures;
  for (const double end : {0.2, 0.2, 0.2, 6.0}) {
    const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(9, 0.0, end);
    captures.push_back(
        make_capture(fmt::format("{}", captures.size()), even_times(9, end), (t + 0.02 * t * t).matrix()));
    add_noise(captures.back(), 1e-3, random);
  }
  const FitResult result = valley_fit(0.02, captures);
  CHECK(result.starts_at_best < 6);
  CHECK_THAT(result.coefficients[0].value, WithinAbs(1.0, 1e-3));
  CHECK(result.other_optima.empty());
  CHECK_THAT(text_of(result.warnings), !Contains("do not distinguish"));
}

TEST_CASE("halves of captures between two optima agree within what is said") {
  // The truth is p = 1; which of the valleys is deeper is chance.
  constexpr int kPairs = 20;
  int disagree = 0, opposite = 0;
  for (std::uint64_t seed = 0; seed < kPairs; ++seed) {
    const FitResult one = valley_fit(0.02, valley_captures(0.02, 0.1, 2 * seed, 8));
    const FitResult two = valley_fit(0.02, valley_captures(0.02, 0.1, 2 * seed + 1, 8));
    opposite += one.coefficients[0].value * two.coefficients[0].value < 0.0 ? 1 : 0;
    const auto sides = [](const FitResult& result) {
      std::vector<double> values = {result.coefficients[0].value};
      for (const OtherOptimum& optimum : result.other_optima) values.push_back(optimum.coefficients[0]);
      return values;
    };
    bool agree = false;
    for (const double a : sides(one)) {
      for (const double b : sides(two)) agree = agree || a * b > 0.0;
    }
    disagree += agree ? 0 : 1;
  }
  CHECK(opposite > 0.1 * kPairs);
  CHECK(disagree <= 0.1 * kPairs);
}

TEST_CASE("what has not converged, or had one start, is said not to be known plainly") {
  const std::vector<Capture> captures = valley_captures(0.2, 0.01, 1, 4);
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.starts.count = 1;
  options.starts.initial["p"] = 2.0;
  options.solver.max_iterations = 1;
  const FitResult stopped = fit(TwoValleys(0.2), captures, options);
  REQUIRE(stopped.status == samara::Termination::max_iterations);
  CHECK_THAT(verdict(stopped, stopped.coefficients[0]),
             Contains("not converged, stopped at") && !Contains("+-"));
  options.solver.max_iterations = 100;
  const FitResult single = fit(TwoValleys(0.2), captures, options);
  CHECK_THAT(text_of(single.warnings), Contains("one start cannot tell"));
}

TEST_CASE("a verdict's error is wider than the standard error where clusters are few") {
  // Student's quantiles: 2.776 for four degrees of freedom, 2.262 for nine.
  FitResult result;
  result.coefficients = {{.name = "p", .value = 1.0, .lower = 0.0, .upper = 2.0, .standard_error = 0.1}};
  Coefficient& p = result.coefficients[0];
  result.clusters = 5;
  CHECK_THAT(widened_error(result, p).value(), WithinAbs(0.1 * 2.7764 / 1.95996, 1e-5));
  result.clusters = 10;
  CHECK_THAT(widened_error(result, p).value(), WithinAbs(0.1 * 2.2622 / 1.95996, 1e-5));
  // Fits with random weights follow bends that the standard error does not see.
  result.bootstrap = Bootstrap{.replicates = 20, .converged = 20, .standard_errors = {0.3}};
  CHECK_THAT(widened_error(result, p).value(), WithinAbs(0.3 * 2.2622 / 1.95996, 1e-5));
  result.bootstrap->standard_errors = {0.05};
  CHECK_THAT(widened_error(result, p).value(), WithinAbs(0.1 * 2.2622 / 1.95996, 1e-5));
  // One cluster carries it: its error is that of the scatter of all ten.
  result.cluster_names.assign(10, "other");
  result.cluster_names[3] = "flight 98";
  p.cluster_shares.assign(10, 0.02);
  p.cluster_shares[3] = 0.82;
  p.effective_clusters = 1.48;
  CHECK_THAT(widened_error(result, p).value(), WithinAbs(0.1 * 2.2622 / 1.95996, 1e-5));
  CHECK(verdict(result, p) == "1.00 +- 0.12, by flight 98 almost alone");
}
