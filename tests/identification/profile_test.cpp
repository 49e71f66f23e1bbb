#include "samara/identification/statistics/profile.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::identification;
using Catch::Matchers::Contains;

namespace {

/// The 95 % quantile of chi2 with one degree of freedom, and its root.
constexpr double kQuantile = 3.841458820694124;
const double kRoot = std::sqrt(kQuantile);

ProfileSolver of(const std::function<double(double)>& cost) {
  return [cost](double value, const Eigen::VectorXd& warm) -> std::optional<ProfileSolution> {
    return ProfileSolution{cost(value), warm};
  };
}

const Eigen::VectorXd kNothing;

}  // namespace

TEST_CASE("the profile of a quadratic cost ends at the normal quantiles, exactly") {
  // cost = 1/2 ((v - 2)/0.3)^2 + 7: D = ((v - 2)/0.3)^2, and its root is interpolated by straight lines.
  const auto cost = [](double v) { return 0.5 * std::pow((v - 2.0) / 0.3, 2) + 7.0; };
  // Whatever the first step is.
  for (const double scale : {0.3, 0.003, 30.0, std::nan("")}) {
    const Profile p = profile({"v", 2.0, 7.0, scale, -50.0, 50.0}, kNothing, of(cost));
    INFO(scale);
    REQUIRE(p.shape == ProfileShape::identified);
    CHECK(*p.interval_lower == Approx(2.0 - 0.3 * kRoot).epsilon(1e-12));
    CHECK(*p.interval_upper == Approx(2.0 + 0.3 * kRoot).epsilon(1e-12));
    CHECK(p.threshold == Approx(7.0 + 0.5 * kQuantile));
    CHECK(p.lower_end == ProfileEnd::crossed);
    CHECK(std::is_sorted(p.values.begin(), p.values.end()));
    CHECK(p.values.size() == p.costs.size());
    CHECK(p.solves <= 40);
  }
}

TEST_CASE("a dispersion widens the interval by its root") {
  const auto cost = [](double v) { return 0.5 * v * v; };
  const Profile p = profile({"v", 0.0, 0.0, 1.0, -50.0, 50.0}, kNothing, of(cost), {.dispersion = 9.0});
  CHECK(*p.interval_upper == Approx(3.0 * kRoot));
  const Profile q = profile({"v", 0.0, 0.0, 1.0, -50.0, 50.0}, kNothing, of(cost), {.confidence = 0.6827});
  CHECK(*q.interval_upper == Approx(1.0).epsilon(1e-4));
}

TEST_CASE("a dispersion that rests on few degrees of freedom gives Student's quantiles") {
  const auto cost = [](double v) { return 0.5 * v * v; };
  // Of t with 4 and with 1 degree of freedom, two-sided 95 %.
  const auto upper = [&](double nu) {
    return *profile({"v", 0.0, 0.0, 1.0, -50.0, 50.0}, kNothing, of(cost), {.degrees_of_freedom = nu})
                .interval_upper;
  };
  CHECK(upper(4.0) == Approx(2.776445).epsilon(1e-6));
  CHECK(upper(1.0) == Approx(12.706205).epsilon(1e-6));
  CHECK(upper(1e6) == Approx(kRoot).epsilon(1e-5));
}

TEST_CASE("the interval follows a bend that a standard error does not see") {
  // D = 2 (v - log v - 1): of the rate of an exponential distribution, one observation.
  const auto cost = [](double v) { return v - std::log(v) - 1.0; };
  const Profile p = profile({"v", 1.0, 0.0, 1.0, 1e-6, 50.0}, kNothing, of(cost));
  REQUIRE(p.shape == ProfileShape::identified);
  // One end of the last bracket is within 3 % of the root, and what lies between is nearly straight.
  CHECK(2.0 * cost(*p.interval_lower) == Approx(kQuantile).epsilon(0.01));
  CHECK(2.0 * cost(*p.interval_upper) == Approx(kQuantile).epsilon(0.01));
}

TEST_CASE("a cost that falls off to one side leaves a one-sided limit") {
  // The least cost is at 5; beyond, 1/2 D rises no higher than 0.5.
  const auto cost = [](double v) {
    const double u = 5.0 - v;
    return u > 0.0 ? 0.5 * u * u : 0.5 * (1.0 - std::exp(u));
  };
  const Profile above = profile({"v", 5.0, 0.0, 1.0, -100.0, 100.0}, kNothing, of(cost));
  CHECK(above.shape == ProfileShape::lower_limit);
  CHECK(*above.interval_lower == Approx(5.0 - kRoot));
  CHECK_FALSE(above.interval_upper);
  CHECK(above.upper_end == ProfileEnd::box);
  CHECK(above.values.back() == 100.0);
  CHECK_THAT(describe(above), Contains("at least 3.04"));

  const Profile mirrored =
      profile({"v", -5.0, 0.0, 1.0, -100.0, 100.0}, kNothing, of([&](double v) { return cost(-v); }));
  CHECK(mirrored.shape == ProfileShape::upper_limit);
  CHECK(*mirrored.interval_upper == Approx(-5.0 + kRoot));
}

TEST_CASE("a limit says how far the other side was explored where solutions ended") {
  const auto cost = [](double v) {
    const double u = 5.0 - v;
    return u > 0.0 ? 0.5 * u * u : 0.5 * (1.0 - std::exp(u));
  };
  const ProfileSolver fails_beyond_six = [&](double v,
                                             const Eigen::VectorXd& start) -> std::optional<ProfileSolution> {
    if (v > 6.0) return {};
    return ProfileSolution{cost(v), start};
  };
  const Profile p = profile({"v", 5.0, 0.0, 1.0, -100.0, 100.0}, kNothing, fails_beyond_six);
  CHECK(p.shape == ProfileShape::lower_limit);
  CHECK(p.upper_end == ProfileEnd::failed);
  CHECK(p.values.back() <= 6.0);
  CHECK_THAT(describe(p), Contains("at least 3.04") && Contains("not explored beyond"));
}

TEST_CASE("a cost that hardly changes is flat, in a box and without one") {
  const auto cost = [](double v) { return 1.0 + 0.1 * std::tanh(v * v); };
  const Profile boxed = profile({"v", 0.0, 1.0, std::nan(""), -3.0, 4.0}, kNothing, of(cost));
  CHECK(boxed.shape == ProfileShape::flat);
  CHECK(boxed.lower_end == ProfileEnd::box);
  CHECK(boxed.values.front() == -3.0);
  CHECK(boxed.values.back() == 4.0);
  CHECK_THAT(describe(boxed), Contains("not determined"));
  const Profile open =
      profile({.name = "v", .best = 0.0, .best_cost = 1.0, .scale = 1.0}, kNothing, of(cost));
  CHECK(open.shape == ProfileShape::flat);
  CHECK(open.upper_end == ProfileEnd::flat);
}

TEST_CASE("a lower minimum met on the way is reported instead of an interval") {
  // Minima at -1 (cost 0.2) and +1 (cost 0), the hill between them below the threshold.
  const auto cost = [](double v) { return std::pow(v * v - 1.0, 2) + 0.1 * (1.0 - v); };
  const double best = -0.974;  // of the upper minimum, roughly
  const Profile p = profile({"v", best, cost(best), 0.3, -3.0, 3.0}, kNothing, of(cost));
  REQUIRE(p.shape == ProfileShape::better_elsewhere);
  CHECK(*p.better_value == Approx(1.0).margin(0.3));
  CHECK(*p.better_cost < cost(best) - 0.1);
  CHECK_FALSE(p.interval_lower);
  CHECK_THAT(describe(p), Contains("better optimum"));
  // From the lower one both valleys are inside the interval.
  const Profile q = profile({"v", 1.0125, cost(1.0125), 0.3, -3.0, 3.0}, kNothing, of(cost));
  CHECK(q.shape == ProfileShape::identified);
  CHECK(*q.interval_lower < -1.0);
}

TEST_CASE("solutions are handed on as warm starts, and failures shorten the steps") {
  // Fails when asked to go farther than 0.4 from its warm start.
  int failures = 0;
  const auto solve = [&](double v, const Eigen::VectorXd& warm) -> std::optional<ProfileSolution> {
    if (std::abs(v - warm[0]) > 0.4) {
      ++failures;
      return {};
    }
    return ProfileSolution{0.5 * v * v, Eigen::VectorXd::Constant(1, v)};
  };
  const Profile p =
      profile({"v", 0.0, 0.0, 1.0, -9.0, 9.0}, Eigen::VectorXd::Zero(1), solve, {.max_points = 60});
  CHECK(failures > 0);
  REQUIRE(p.shape == ProfileShape::identified);
  CHECK(*p.interval_upper == Approx(kRoot));
}

TEST_CASE("where nothing can be solved the side stays open and says so") {
  const auto solve = [](double v, const Eigen::VectorXd& warm) -> std::optional<ProfileSolution> {
    if (v > 0.5) return {};
    return ProfileSolution{0.5 * v * v, warm};
  };
  const Profile p = profile({"v", 0.0, 0.0, 1.0, -9.0, 9.0}, kNothing, solve);
  CHECK(p.shape == ProfileShape::lower_limit);
  CHECK(p.upper_end == ProfileEnd::failed);
}

TEST_CASE("an optimum at a bound has one side") {
  const auto cost = [](double v) { return v + 0.5 * v * v; };
  const Profile p = profile({"v", 0.0, 0.0, 0.5, 0.0, 9.0}, kNothing, of(cost));
  CHECK(p.shape == ProfileShape::upper_limit);
  CHECK(p.lower_end == ProfileEnd::box);
}

TEST_CASE("profiles refuse targets and options without meaning") {
  const auto solve = of([](double v) { return v * v; });
  CHECK_THROWS_AS(profile({"v", 2.0, 0.0, 1.0, -1.0, 1.0}, kNothing, solve), samara::ArgumentError);
  CHECK_THROWS_AS(profile({"v", std::nan(""), 0.0, 1.0, -1.0, 1.0}, kNothing, solve), samara::ArgumentError);
  CHECK_THROWS_AS(profile({"v", 0.0, 0.0}, kNothing, solve, {.confidence = 1.0}), samara::ArgumentError);
  CHECK_THROWS_AS(profile({"v", 0.0, 0.0}, kNothing, solve, {.dispersion = 0.0}), samara::ArgumentError);
  CHECK_THROWS_AS(profile({"v", 0.0, 0.0}, kNothing, solve, {.degrees_of_freedom = 0.0}),
                  samara::ArgumentError);
}
