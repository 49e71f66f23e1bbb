#include <catch2/catch.hpp>

#include "samara/identification/fit/fit.h"
#include "synthetic.h"

using namespace samara::identification;

TEST_CASE("robust losses resist outliers that ruin the plain fit") {
  constexpr double kC_D = 1.15;
  const auto family = coin_family();
  std::mt19937_64 random(7);
  std::vector<Capture> captures;
  for (int c = 0; c < 6; ++c) {
    captures.push_back(coin_capture(fmt::format("{}", c), kC_D, 0.05 * c, 0.0));
    add_noise(captures.back(), 3e-4, random);
    // The tracker held a reflection for the last two frames: a tenth of the frames, 5 cm off.
    captures.back().channels[0].values.tail(2).array() -= 0.05;
  }
  const auto error = [&](LossKind kind) {
    FitOptions options;
    options.loss.kind = kind;
    options.loss.length_scale = 1e-3;
    const FitResult result = fit(*family, captures, options);
    INFO(to_string(kind) << ": " << result.message);
    CHECK(result.status == samara::Termination::converged);
    return std::abs(result.coefficients[0].value - kC_D);
  };
  const double plain = error(LossKind::none);
  CHECK(plain > 0.3);
  CHECK(error(LossKind::huber) < 0.3 * plain);
  CHECK(error(LossKind::soft_l1) < 0.3 * plain);
  CHECK(error(LossKind::cauchy) < 0.05);
}

TEST_CASE("a loss that bends far within the noise is told of, and no other") {
  const auto family = coin_family();
  std::mt19937_64 random(8);
  std::vector<Capture> captures{coin_capture("drop", 1.15, 0.1, 0.0)};
  constexpr double kNoise = 1e-3;
  add_noise(captures.back(), kNoise, random);
  const auto is_told = [&](LossKind kind, double scale) {
    FitOptions options;
    options.loss.kind = kind;
    options.loss.length_scale = scale;
    const FitResult result = fit(*family, captures, options);
    CHECK(result.status == samara::Termination::converged);
    return result.warnings.has(WarningKind::errors, "too many residuals lie beyond the bend of the loss");
  };
  CHECK(is_told(LossKind::huber, 0.1 * kNoise));
  CHECK(is_told(LossKind::cauchy, 0.1 * kNoise));
  CHECK_FALSE(is_told(LossKind::huber, 1.345 * kNoise));
  CHECK_FALSE(is_told(LossKind::cauchy, 2.385 * kNoise));
  CHECK_FALSE(is_told(LossKind::none, 0.1 * kNoise));
}
