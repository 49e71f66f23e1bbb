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
