#include <catch2/catch.hpp>

#include "samara/identification/fit/fit.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kC_D = 1.15;
const std::vector<double> kV0 = {-0.1, 0.0, 0.15, 0.3};
const std::vector<double> kOffsets = {0.2, -0.03, 0.0, 5.0};

std::vector<Capture> coins() {
  std::vector<Capture> captures;
  for (std::size_t c = 0; c < kV0.size(); ++c) {
    captures.push_back(coin_capture(fmt::format("coin {}", c), kC_D, kV0[c], kOffsets[c]));
  }
  return captures;
}

}  // namespace

TEST_CASE("a fit without noise recovers the truth") {
  const auto family = coin_family();
  const std::vector<Capture> captures = coins();
  for (const LossKind kind : {LossKind::none, LossKind::huber, LossKind::soft_l1, LossKind::cauchy}) {
    INFO(to_string(kind));
    FitOptions options;
    options.loss.kind = kind;
    const FitResult result = fit(*family, captures, options);
    INFO(result.message);
    CHECK(result.status == samara::Termination::converged);
    REQUIRE(result.coefficients.size() == 1);
    CHECK(result.coefficients[0].name == "C_D");
    CHECK_THAT(result.coefficients[0].value, WithinRel(kC_D, 1e-6));
    CHECK(result.starts_at_best == 3);
    for (std::size_t c = 0; c < captures.size(); ++c) {
      REQUIRE(result.captures[c].nuisances.size() == 2);
      CHECK(result.captures[c].nuisances[0].name == "v(0)");
      CHECK_THAT(result.captures[c].nuisances[0].value, WithinAbs(kV0[c], 1e-6));
      CHECK(result.captures[c].nuisances[1].name == "offset of x");
      CHECK_THAT(result.captures[c].nuisances[1].value, WithinAbs(kOffsets[c], 1e-7));
    }
  }
}

TEST_CASE("a fit needs neither all frames nor the same frames in all captures") {
  const auto family = coin_family();
  std::vector<Capture> captures = coins();
  for (const Eigen::Index missing : {0, 3, 4, 20, 24}) captures[1].channels[0].values[missing] = std::nan("");
  FitOptions options;
  options.compared.span = 0.3;
  const FitResult result = fit(*family, captures, options);
  CHECK_THAT(result.coefficients[0].value, WithinRel(kC_D, 1e-6));
  CHECK(result.captures[0].frames == 19);
  CHECK(result.captures[1].frames == 16);
  CHECK(result.residual_count == 3 * 19 + 16);
}

TEST_CASE("coordinates take the roles they are given") {
  const auto family = coin_family();
  const std::vector<Capture> captures = coins();
  FitOptions options;
  SECTION("a parameter of each capture's own") {
    options.unknowns.per_capture = {"C_D"};
    const FitResult result = fit(*family, captures, options);
    CHECK(result.status == samara::Termination::converged);
    CHECK(result.coefficients.empty());
    REQUIRE(result.captures[2].nuisances.size() == 3);
    for (const CaptureFit& capture : result.captures)
      CHECK_THAT(capture.nuisances[0].value, WithinRel(kC_D, 1e-5));
  }
  SECTION("an initial value that is fixed") {
    options.unknowns.fixed = {{"v(0)", kV0[2]}};
    const FitResult result = fit(*family, std::span(captures).subspan(2, 1), options);
    CHECK_THAT(result.coefficients[0].value, WithinRel(kC_D, 1e-6));
    CHECK(result.captures[0].nuisances.size() == 1);
    CHECK(result.fixed.at("v(0)") == kV0[2]);
    CHECK(result.fixed.at("thickness") == 2.55e-3);
  }
  SECTION("an initial value that is shared") {
    options.unknowns.shared = {"v(0)"};
    std::vector<Capture> equal = {coin_capture("a", kC_D, 0.1, 0.0), coin_capture("b", kC_D, 0.1, 0.4)};
    const FitResult result = fit(*family, equal, options);
    REQUIRE(result.coefficients.size() == 2);
    CHECK_THAT(result.coefficients[0].value, WithinRel(kC_D, 1e-6));
    CHECK_THAT(result.coefficients[1].value, WithinRel(0.1, 1e-6));
  }
  SECTION("no unknowns of the captures' own at all") {
    options.unknowns.shared = {"v(0)"};
    options.unknowns.offsets = std::vector<std::string>{};
    const FitResult result = fit(*family, std::vector{coin_capture("a", kC_D, 0.1, 0.0)}, options);
    CHECK(result.status == samara::Termination::converged);
    CHECK_THAT(result.coefficients[0].value, WithinRel(kC_D, 1e-6));
    CHECK(result.captures[0].nuisances.empty());
  }
}

TEST_CASE("the result holds what was measured and what the model says") {
  const auto family = coin_family();
  std::vector<Capture> captures = coins();
  std::mt19937_64 random(3);
  for (Capture& capture : captures) add_noise(capture, 1e-3, random);
  const FitResult result = fit(*family, captures);
  const CaptureFit& capture = result.captures[1];
  CHECK(capture.times == captures[1].times);
  CHECK(capture.measured.col(0) == captures[1].channels[0].values);
  const Eigen::VectorXd difference = (capture.measured - capture.model).col(0);
  CHECK_THAT(capture.residuals[0].rms, WithinRel(std::sqrt(difference.squaredNorm() / 25.0), 1e-12));
  // 100 values of 1 mm noise less 9 unknowns: 0.95 mm, give or take 7 %.
  CHECK_THAT(result.residuals[0].rms, WithinRel(0.95e-3, 0.25));
  // Half the sum of squares over (2 mm)^2, with few frames beyond the bend.
  CHECK_THAT(result.cost, WithinRel(0.5 * 100.0 * std::pow(result.residuals[0].rms / 2e-3, 2), 0.02));
}

TEST_CASE("noise moves the coefficient by no more than three standard errors") {
  const auto family = coin_family();
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    std::mt19937_64 random(seed);
    std::vector<Capture> captures;
    for (int c = 0; c < 8; ++c) {
      captures.push_back(coin_capture(fmt::format("{}", c), kC_D, 0.04 * c, 0.1));
      add_noise(captures.back(), 5e-4, random);
    }
    const FitResult result = fit(*family, captures);
    const Coefficient& C_D = result.coefficients[0];
    INFO("C_D = " << C_D.value << " +- " << C_D.standard_error.value_or(-1.0));
    REQUIRE(C_D.standard_error);
    CHECK(std::abs(C_D.value - kC_D) < 3.0 * *C_D.standard_error);
    CHECK(*C_D.standard_error < 0.05);
  }
}

TEST_CASE("the same fit gives the same bits") {
  const auto family = coin_family();
  std::vector<Capture> captures = coins();
  std::mt19937_64 random(5);
  for (Capture& capture : captures) add_noise(capture, 1e-3, random);
  const FitResult one = fit(*family, captures);
  const FitResult two = fit(*family, captures);
  CHECK(one.coefficients[0].value == two.coefficients[0].value);
  CHECK(*one.coefficients[0].standard_error == *two.coefficients[0].standard_error);
}
