#include <bit>
#include <cmath>

#include <catch2/catch.hpp>

#include "samara/pgd/sampling/sampling.h"
#include "samara/pgd/tensors/random.h"
#include "sampled_functions.h"

// What a build by sampling may call met.

using namespace samara::pgd;
using Catch::Contains;

namespace {

/// A plane and an oblique Gaussian peak of the plane's range, in six coordinates: the widths are 0.08 to
/// 0.15, and it stands far from the diagonal.
double plane_with_peak(std::span<const double> x) {
  const double plane = x[0] + 0.5 * x[1] - 0.7 * x[2] + 0.3 * x[3] - 0.2 * x[4] + 0.4 * x[5];
  const double u = x[0] - 0.7, v = x[1] - 0.2, w = x[2] - 0.6, p = x[3] - 0.3, q = x[4] - 0.8, r = x[5] - 0.4;
  const double turned[] = {0.8 * u + 0.6 * v, 0.8 * v - 0.6 * u,   0.6 * w - 0.8 * p,
                           0.6 * p + 0.8 * w, 0.5 * q + 0.866 * r, 0.5 * r - 0.866 * q};
  const double widths[] = {0.08, 0.15, 0.1, 0.12, 0.09, 0.14};
  double square = 0.0;
  for (int k = 0; k < 6; ++k) square += std::pow(turned[k] / widths[k], 2);
  return plane + 3.1 * std::exp(-0.5 * square);
}

/// The same at the same point, in -1 .. 1, without any order between points.
double noise_at(std::span<const double> x) {
  std::uint64_t state = 7;
  for (const double value : x) state = Random(state ^ std::bit_cast<std::uint64_t>(value)).bits();
  return 2.0 * Random(state).uniform() - 1.0;
}

}  // namespace

TEST_CASE("an oblique peak on a plane is found by its tails, or the tolerance is not called met") {
  const std::vector<double> top = {0.7, 0.2, 0.6, 0.3, 0.8, 0.4};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SamplingResult result = sample(unit_box(6), {{"f"}}, one_output(plane_with_peak),
                                         {.tolerance = 1e-2, .max_calls = 4000, .seed = seed});
    INFO("seed " << seed << ": " << result.message);
    CHECK_FALSE(result.tolerance_met());
    // The peak was seen: the plane alone is met at once.
    CHECK(result.error > 1e-2);
  }
  const SamplingResult whole = sample(unit_box(6), {{"f"}}, one_output(plane_with_peak), {.tolerance = 1e-2});
  INFO(whole.message);
  REQUIRE(whole.tolerance_met());
  CHECK((*whole.field)(top)[0] == Approx(plane_with_peak(top)).margin(1e-2 * whole.range[0]));
}

TEST_CASE("noise below the tolerance does not keep a build from its end") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Scalar f = [](std::span<const double> x) { return std::exp(-sum_of(x)) + 1e-3 * noise_at(x); };
    const SamplingResult result =
        sample(unit_box(5), {{"f"}}, one_output(f), {.tolerance = 1e-2, .max_calls = 20'000, .seed = seed});
    INFO(result.message);
    CHECK(result.tolerance_met());
    CHECK(result.calls < 3000);
  }
}

TEST_CASE("noise above the tolerance is measured, said, and ends the build early") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Scalar f = [](std::span<const double> x) { return std::exp(-sum_of(x)) + 0.03 * noise_at(x); };
    const SamplingResult result =
        sample(unit_box(5), {{"f"}}, one_output(f), {.tolerance = 1e-2, .max_calls = 100'000, .seed = seed});
    INFO(result.message);
    CHECK(result.status == samara::Termination::noise);
    CHECK(result.calls < 5000);
    CHECK_THAT(result.message, Contains("noise of 0.0"));
    // Uniform noise of 0.03 has a root mean square of 0.0173; seven values a place estimate it roughly.
    REQUIRE(result.noise);
    CHECK(*result.noise > 0.4 * 0.0173 / result.range[0]);
    CHECK(*result.noise < 2.5 * 0.0173 / result.range[0]);
  }
}

TEST_CASE("a smooth function has no noise, however steep") {
  // A kink makes the build look for noise.
  const Scalar kink = [](std::span<const double> x) {
    return std::abs(sum_of(x) - 2.0) + std::exp(3.0 * x[0]);
  };
  const SamplingResult result =
      sample(unit_box(4), {{"f"}}, one_output(kink), {.tolerance = 1e-5, .max_calls = 20'000});
  INFO(result.message);
  CHECK_FALSE(result.tolerance_met());
  CHECK(result.noise.value_or(0.0) < 1e-9);
}

TEST_CASE("points of a challenge go into the sample, until it finds nothing any more") {
  const Scalar f = [](std::span<const double> x) { return x[0] + 1.0 / (1e-4 + x[1] * x[1] + x[0] * x[0]); };
  int challenges = 0, refutations = 0;
  SamplingOptions options{.tolerance = 1e-3, .max_calls = 50'000};
  options.challenge = [&](const SamplingResult& claim) {
    ++challenges;
    const Eigen::MatrixXd corner = Eigen::MatrixXd::Constant(2, 1, 0.004);
    const double error = std::abs((*claim.field)({corner.data(), 2})[0] - f({corner.data(), 2}));
    refutations += error > 1e-3 * claim.range[0] ? 1 : 0;
    return error > 1e-3 * claim.range[0] ? corner : Eigen::MatrixXd(2, 0);
  };
  const SamplingResult result = sample(unit_box(2), {{"f"}}, one_output(f), options);
  INFO(result.message);
  REQUIRE(result.tolerance_met());
  CHECK(challenges == refutations + 1);
  const std::vector<double> corner = {0.004, 0.004};
  CHECK((*result.field)(corner)[0] == Approx(f(corner)).margin(1e-3 * result.range[0]));
  // One that is never content ends the build.
  options.challenge = [](const SamplingResult&) {
    return Eigen::MatrixXd(Eigen::MatrixXd::Constant(2, 1, 0.5));
  };
  const SamplingResult refuted =
      sample(unit_box(2), {{"f"}}, one_output([](auto x) { return x[0]; }), options);
  CHECK(refuted.status == samara::Termination::refuted);
  CHECK_FALSE(refuted.tolerance_met());
}
