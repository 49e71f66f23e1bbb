#include "samara/identification/statistics/loss.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "files.h"

using namespace samara::identification;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr LossKind kKinds[] = {LossKind::none, LossKind::huber, LossKind::soft_l1, LossKind::cauchy};

}  // namespace

TEST_CASE("psi is half the derivative of rho, and dpsi that of psi") {
  const double h = 1e-5;
  for (const LossKind kind : kKinds) {
    for (const double r : {-7.0, -1.3, -0.6, 0.0, 0.2, 0.9, 2.5, 40.0}) {
      INFO(to_string(kind) << " at " << r);
      const LossValue up = loss_value(kind, r + h);
      const LossValue down = loss_value(kind, r - h);
      const LossValue at = loss_value(kind, r);
      // Truncation h^2/6 times third derivatives of at most ten; rounding eps * rho/h.
      CHECK_THAT(at.psi, WithinAbs((up.rho - down.rho) / (4.0 * h), 1e-8 + 1e-10 * at.rho));
      CHECK_THAT(at.dpsi, WithinAbs((up.psi - down.psi) / (2.0 * h), 1e-8));
    }
  }
}

TEST_CASE("every loss is the square for small residuals") {
  for (const LossKind kind : kKinds) {
    const LossValue value = loss_value(kind, 1e-9);
    CHECK_THAT(value.rho, WithinRel(1e-18, 1e-12));
    CHECK_THAT(value.psi, WithinRel(1e-9, 1e-12));
    CHECK_THAT(value.dpsi, WithinRel(1.0, 1e-12));
  }
}

TEST_CASE("far residuals count as the loss promises") {
  const double r = 1e6;
  CHECK_THAT(loss_value(LossKind::huber, r).rho, WithinRel(2.0 * r, 1e-5));
  CHECK_THAT(loss_value(LossKind::soft_l1, r).rho, WithinRel(2.0 * r, 1e-5));
  CHECK_THAT(loss_value(LossKind::cauchy, r).rho, WithinRel(2.0 * std::log(r), 1e-5));
  CHECK(loss_value(LossKind::cauchy, r).psi < 2e-6);
}

TEST_CASE("losses are found by their names") {
  for (const LossKind kind : kKinds) CHECK(loss_kind_from_string(to_string(kind)) == kind);
  CHECK(error_of<samara::ArgumentError>([] { loss_kind_from_string("hubert"); }) ==
        "there is no loss \"hubert\"; did you mean \"huber\"?");
}
