#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fitted_motion.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// k held; v(0) and the offset of x are each capture's own.
FitOptions held_values() {
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.unknowns.fixed["k"] = 1.0;
  options.starts.count = 1;
  return options;
}

double own_value(const FitResult& result, std::size_t capture, const std::string& name) {
  for (const Nuisance& n : result.captures.at(capture).nuisances) {
    if (n.name == name) return n.value;
  }
  return NAN;
}

}  // namespace

TEST_CASE("a prior of each capture's own coordinate weighs against its frames") {
  // With k and the offset held, x is linear in v(0): x = v(0) a_i. Frames say 1.0 with a weight of
  // sum a_i^2/scale^2, the prior says 2.0 with 1/deviation^2; the minimum is their weighted mean.
  const BrakedFamily family;
  const std::vector<double> times = even_times(9, 2.0);
  const Eigen::VectorXd a = BrakedFamily::depths(1.0, 1.0, times);
  const std::vector<Capture> captures = {make_capture("a", times, a), make_capture("b", times, 1.5 * a)};
  FitOptions options = held_values();
  options.unknowns.offsets = std::vector<std::string>{};
  options.loss.length_scale = 0.5;
  options.priors.coordinates["v(0)"] = {.mean = 2.0, .deviation = 0.3};
  const FitResult result = fit(family, captures, options);
  const double frames = a.squaredNorm() / 0.25;
  const double prior = 1.0 / 0.09;
  CHECK_THAT(own_value(result, 0, "v(0)"), WithinRel((frames + 2.0 * prior) / (frames + prior), 1e-7));
  CHECK_THAT(own_value(result, 1, "v(0)"), WithinRel((1.5 * frames + 2.0 * prior) / (frames + prior), 1e-7));
}

TEST_CASE("priors are for free coordinates, and logarithmic ones for positive boxes") {
  const BrakedFamily family;
  const std::vector<double> times = even_times(9, 2.0);
  const std::vector<Capture> captures = {make_capture("a", times, BrakedFamily::depths(1.0, 1.0, times))};
  FitOptions options = held_values();
  options.priors.coordinates["k"] = {.mean = 1.0, .deviation = 0.1};
  CHECK_THROWS_WITH(fit(family, captures, options), Catch::Matchers::Contains("is not a free coordinate"));
}

TEST_CASE("a fitted motion goes on beyond its frames") {
  const BrakedFamily family;
  const std::vector<double> times = even_times(9, 1.0);
  const Eigen::VectorXd x = BrakedFamily::depths(1.0, 1.2, times).array() + 0.4;
  const std::vector<Capture> captures = {make_capture("a", times, x)};
  const FitOptions options = held_values();
  const FitResult result = fit(family, captures, options);
  const auto beyond = fitted_motion(family, options, result, 0, {0.5, 2.0}, {"x"});
  REQUIRE(beyond.has_value());
  CHECK_THAT((*beyond)(0, 0), WithinAbs(BrakedFamily::depth(1.0, 1.2, 0.5) + 0.4, 1e-8));
  CHECK_THAT((*beyond)(1, 0), WithinAbs(BrakedFamily::depth(1.0, 1.2, 2.0) + 0.4, 1e-8));
  CHECK_THROWS_AS(fitted_motion(family, options, result, 1, {0.5}, {"x"}), samara::ArgumentError);
}
