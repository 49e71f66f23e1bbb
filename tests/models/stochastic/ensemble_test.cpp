#include "samara/models/stochastic/ensemble.h"

#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "leaves_in_gusts.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/fluid_seen.h"
#include "samara/models/stochastic/realisations.h"

using namespace samara::models;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// Scatter of the means of 50 disjoint groups of 20 over the standard error that one of 1000 claims, for x, y, z.
double scatter_over_claim(const AirSource& air) {
  const std::vector<double> end = {0.2};
  const Ensemble all = realise(leaf(), {}, air, end, {.realisations = 1000, .keep = 1000});
  double ratio = 0.0;
  for (int s = 0; s < 3; ++s) {
    Eigen::ArrayXd means(50);
    for (int group = 0; group < 50; ++group) {
      double sum = 0.0;
      for (int n = 0; n < 20; ++n) sum += all.kept[static_cast<std::size_t>(20 * group + n)](0, s);
      means[group] = sum / 20.0;
    }
    const double scatter = std::sqrt((means - means.mean()).square().sum() / 49.0);
    ratio += scatter / (all.mean_error(0, s) * std::sqrt(50.0)) / 3.0;
  }
  return ratio;
}

}  // namespace

TEST_CASE(
    "standard errors are what groups of realisations scatter by, and lie where realisations are copies") {
  CHECK_THAT(scatter_over_claim(*breeze()), WithinAbs(1.0, 0.2));
  CHECK_FALSE(std::abs(scatter_over_claim(Twins(breeze())) - 1.0) < 0.2);
}

TEST_CASE("antithetic pairs are mirror images, and their errors come from pairs") {
  // A body that the fluid moves and no weight: pairs cancel to the last digit.
  const ParametricModel ball(find_model("sphere_flight_in_gusts"), {{"g", 0.0}, {"C_M", 0.0}}, {});
  const auto air = fluid_seen_in(uniform_turbulence(1.5, 0.5), 3, {.C_0 = 6.0});
  const std::vector<double> times = {0.0, 0.1, 0.2};
  const Ensemble pairs = realise(ball, {}, *air, times, {.realisations = 64, .keep = 2, .antithetic = true});
  CHECK((pairs.kept[0] + pairs.kept[1]).cwiseAbs().maxCoeff() < 1e-14);
  CHECK(pairs.standard_deviation(2, 0) > 1e-3);
  CHECK(pairs.mean_error(2, 0) < 1e-14);
  CHECK_THROWS_WITH(realise(ball, {}, *air, times, {.realisations = 7, .antithetic = true}),
                    Contains("realisations is 7; an even number"));
}

TEST_CASE("leaves land where they cross the ground, and their landings have errors") {
  std::vector<double> times;
  for (int k = 0; k <= 30; ++k) times.push_back(0.1 * k);
  const Ensemble cloud =
      realise(leaf(1.0), {}, *breeze(), times, {.realisations = 320, .ground = 0.0, .keep = 1});
  CHECK(cloud.count(RealisationStatus::landed) == 320);
  CHECK(cloud.flying[0] == 320);
  CHECK(cloud.flying[30] == 0);
  CHECK(std::isnan(cloud.mean(30, 0)));
  const LandingStatistics landing = landing_statistics(cloud);
  CHECK(landing.landed == 320);
  double mean = 0.0, square = 0.0;
  for (const Landing& one : cloud.landings) {
    CHECK_THAT(one.position.z(), WithinAbs(0.0, 1e-12));
    mean += one.position.x() / 320.0;
  }
  for (const Landing& one : cloud.landings) square += std::pow(one.position.x() - mean, 2) / 319.0;
  CHECK_THAT(landing.mean.x(), WithinRel(mean, 1e-12));
  CHECK_THAT(landing.covariance(0, 0), WithinRel(square, 1e-10));
  CHECK_THAT(landing.mean_error.x(), WithinRel(std::sqrt(square / 320.0), 1e-10));
  // Ten groups: their scatter is that of a variance of 320 normal numbers, within what ten tell.
  CHECK_THAT(landing.covariance_error(0, 0), WithinRel(square * std::sqrt(2.0 / 320.0), 0.8));
  CHECK(landing.quantiles(0, 0) < landing.quantiles(2, 0));
  CHECK(landing.quantiles(2, 0) < landing.quantiles(4, 0));
  CHECK_THAT(cloud.relative_error,
             WithinRel(landing.mean_error.norm() /
                           std::sqrt(landing.mean.squaredNorm() + landing.covariance.trace() + 1.0),
                       0.01));
  CHECK_THROWS_WITH(realise(leaf(-1.0), {}, *breeze(), times, {.ground = 0.0}),
                    Contains("expected below the start"));
}

TEST_CASE("a tumbling plate's turns are counted") {
  const ParametricModel spinner(find_model("falling_plate_in_gusts"),
                                {{"semi_chord", 0.02},
                                 {"semi_thickness", 0.002},
                                 {"density", 1500.0},
                                 {"mu1", 0.0},
                                 {"mu2", 0.0},
                                 {"C_T", 0.0},
                                 {"C_R", 0.0},
                                 {"A", 0.0},
                                 {"B", 0.0},
                                 {"theta(0)", 0.0},
                                 {"g", 1e-6},
                                 {"w(0)", 100.0}},
                                {});
  const std::vector<double> times = {1.0};
  const auto still = fluid_seen_in(uniform_turbulence(0.0, 1.0), 1);
  const Ensemble cloud = realise(spinner, {}, *still, times, {.realisations = 3});
  for (const int turns : cloud.half_turns) CHECK(turns == 32);  // 100 rad are 31.8 half turns
  CHECK(cloud.mean_half_turns.value == 32.0);
}

TEST_CASE("steps longer than the air changes in are counted") {
  const std::vector<double> times = {0.2};
  const auto air = fluid_seen_in(uniform_turbulence(0.1, 0.2), 5, {.C_0 = 6.0, .crossing = false});
  const double T = 4.0 * 0.1 / (3.0 * 6.0 * 0.2);  // 0.111 s
  const Ensemble fine = realise(leaf(), {}, *air, times, {.realisations = 4, .step = 1e-3});
  CHECK(fine.steps.beyond_tenth == 0.0);
  CHECK_THAT(fine.steps.shortest, WithinRel(T, 0.2));
  CHECK(realise(leaf(), {}, *air, times, {.realisations = 4, .step = 0.0201}).steps.beyond_tenth == 1.0);
  CHECK(realise(leaf(), {}, *air, times, {.realisations = 4, .step = 0.0201}).steps.beyond_third == 0.0);
  CHECK(realise(leaf(), {}, *air, times, {.realisations = 4, .step = 0.041}).steps.beyond_third == 1.0);
}

TEST_CASE("an ensemble stops when its mean is known well enough, or when it is cancelled") {
  const std::vector<double> times = {0.3};
  const Ensemble met = realise(leaf(), {}, *breeze(), times, {.realisations = 4096, .relative_error = 0.02});
  CHECK(met.realisations() < 4096);
  CHECK(met.relative_error <= 0.02);
  CHECK_FALSE(met.cancelled);
  const Ensemble cancelled =
      realise(leaf(), {}, *breeze(), times,
              {.realisations = 512, .progress = [](const samara::Progress&) { return false; }});
  CHECK(cancelled.cancelled);
  CHECK(cancelled.realisations() < 512);
}
