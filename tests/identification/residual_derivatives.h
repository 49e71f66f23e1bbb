#pragma once

#include <catch2/catch.hpp>

#include "samara/identification/problem/segment_residual.h"

/// Holds the derivatives of a joined segment's residuals to differences, at random unknowns.
inline void check_derivatives(samara::identification::SegmentResidual& residual, Eigen::VectorXd shared,
                              Eigen::VectorXd own, Eigen::VectorXd next) {
  REQUIRE(residual.evaluate(shared.data(), own.data(), next.data(), true));
  const Eigen::MatrixXd by_shared = residual.by_shared(), by_own = residual.by_own(),
                        by_next = residual.by_next();
  const auto check = [&](Eigen::VectorXd& block, const Eigen::MatrixXd& derivatives) {
    constexpr double kStep = 1e-5;
    for (Eigen::Index k = 0; k < block.size(); ++k) {
      const double before = block[k];
      block[k] = before + kStep;
      REQUIRE(residual.evaluate(shared.data(), own.data(), next.data(), false));
      const Eigen::VectorXd up = residual.residual();
      block[k] = before - kStep;
      REQUIRE(residual.evaluate(shared.data(), own.data(), next.data(), false));
      const Eigen::VectorXd difference = (up - residual.residual()) / (2.0 * kStep);
      block[k] = before;
      INFO("unknown " << k);
      // Residuals up to 100, steps of 1e-5: rounding of 1e-9, truncation of 1e-10 times third derivatives.
      CHECK((derivatives.col(k) - difference).cwiseAbs().maxCoeff() <
            1e-4 * (1.0 + derivatives.col(k).cwiseAbs().maxCoeff()));
    }
  };
  check(shared, by_shared);
  check(own, by_own);
  check(next, by_next);
}
