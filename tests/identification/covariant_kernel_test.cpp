#include "samara/identification/forecasts/covariant_kernel.h"

#include <cmath>
#include <complex>
#include <numbers>

#include <catch2/catch.hpp>

#include "samara/base/streams.h"

using namespace samara::identification;

namespace {

constexpr std::complex<double> kQuarterTurn(0.0, 1.0);

TurningRows rows_at_random(Eigen::Index count, Eigen::Index views, std::uint64_t number) {
  samara::Stream stream(61, number);
  TurningRows rows{Eigen::MatrixXcd(count, 3), Eigen::MatrixXd(count, 2), Eigen::MatrixXcd(count, views)};
  for (Eigen::MatrixXcd* both : {&rows.level, &rows.views}) {
    both->real() = both->real().unaryExpr([&](double) { return stream.normal(); });
    both->imag() = both->imag().unaryExpr([&](double) { return stream.normal(); });
  }
  rows.others = rows.others.unaryExpr([&](double) { return stream.normal(); });
  return rows;
}

TurningRows mirrored_rows(TurningRows rows) {
  rows.level = rows.level.conjugate().eval();
  return rows;
}

/// Means over so many turns of the Gaussian kernel between a moment and a centre, times the n-th power of the turn.
std::complex<double> mean_over_turns(const TurningRows& moments, Eigen::Index moment,
                                     const TurningRows& centres, Eigen::Index centre, int turns, int power) {
  std::complex<double> sum = 0.0;
  for (int q = 0; q < turns; ++q) {
    const std::complex<double> turn = std::polar(1.0, 2.0 * std::numbers::pi * q / turns);
    Eigen::RowVectorXcd views = centres.views.row(centre);
    if (q % 2 == 1) views = kQuarterTurn * views.conjugate();  // real and imaginary parts exchanged
    const double square = (moments.level.row(moment) - turn * centres.level.row(centre)).squaredNorm() +
                          (moments.others.row(moment) - centres.others.row(centre)).squaredNorm() +
                          (moments.views.row(moment) - views).squaredNorm();
    sum += std::exp(-0.5 * square) * std::pow(turn, power);
  }
  return sum / static_cast<double>(turns);
}

/// @param turns over which the mean is taken
void check_means(Eigen::Index views, int turns) {
  const TurningRows moments = rows_at_random(6, views, 1), centres = rows_at_random(5, views, 2);
  const Eigen::MatrixXd still = still_kernel(moments, centres);
  const TurningKernel turning = turning_kernel(moments, centres);
  const TurningRows mirror = mirrored_rows(centres);
  constexpr double kRoundOff = 1e-13;
  for (Eigen::Index m = 0; m < 6; ++m) {
    for (Eigen::Index c = 0; c < 5; ++c) {
      const auto half_mean = [&](const TurningRows& of, int power) {
        return 0.5 * mean_over_turns(moments, m, of, c, turns, power);
      };
      CHECK(still(m, c) == Approx((half_mean(centres, 0) + half_mean(mirror, 0)).real()).margin(kRoundOff));
      CHECK(std::abs(turning.as_seen(m, c) - half_mean(centres, 1)) < kRoundOff);
      CHECK(std::abs(turning.mirrored(m, c) - half_mean(mirror, 1)) < kRoundOff);
    }
  }
}

}  // namespace

TEST_CASE(
    "covariant kernels are means of the Gaussian kernel over all turns, with views over quarter turns") {
  check_means(0, 64);
  check_means(2, 4);
}
