#include "samara/pgd/sampling/error_climb.h"

#include <cmath>

#include <Eigen/QR>
#include <catch2/catch.hpp>

#include "samara/pgd/tensors/random.h"

using namespace samara::pgd;

namespace {

/// |W (x - c)|, turned by plane rotations, with widths of 0.08 and 0.15 in turn.
struct Peak {
  Eigen::MatrixXd W;
  Eigen::VectorXd centre;

  explicit Peak(int dimensions, std::uint64_t seed) {
    Random random(seed);
    W.setIdentity(dimensions, dimensions);
    for (int k = 0; k < dimensions; ++k) W(k, k) = 1.0 / (k % 2 == 0 ? 0.08 : 0.15);
    for (int k = 0; k + 1 < dimensions; ++k) {
      const double angle = 3.0 * random.uniform();
      const Eigen::RowVectorXd a = W.row(k), b = W.row(k + 1);
      W.row(k) = std::cos(angle) * a + std::sin(angle) * b;
      W.row(k + 1) = std::cos(angle) * b - std::sin(angle) * a;
    }
    centre = Eigen::VectorXd::NullaryExpr(dimensions, [&] { return 0.2 + 0.6 * random.uniform(); });
  }

  double height(const Eigen::VectorXd& x) const { return std::exp(-0.5 * (W * (x - centre)).squaredNorm()); }
};

ErrorsAt errors_of(const Peak& peak, long& calls) {
  return [&](const Eigen::MatrixXd& points) {
    calls += points.cols();
    Eigen::VectorXd errors(points.cols());
    for (Eigen::Index j = 0; j < points.cols(); ++j) errors[j] = peak.height(points.col(j));
    return errors;
  };
}

}  // namespace

TEST_CASE("a climb from the tail of an oblique peak ends at its top") {
  for (const int d : {2, 4, 6, 8}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Peak peak(d, seed);
      // At a random place four widths away, where the height is 3e-4.
      Random random(seed + 100);
      const Eigen::VectorXd direction = Eigen::VectorXd::NullaryExpr(d, [&] { return random.normal(); });
      const Eigen::VectorXd way = peak.W.colPivHouseholderQr().solve(4.0 * direction.normalized());
      const Eigen::VectorXd start = (peak.centre + way).cwiseMax(0.0).cwiseMin(1.0);
      long calls = 0;
      const Eigen::VectorXd errors = Eigen::VectorXd::Constant(1, peak.height(start));
      const Climbs climbs = climb_errors(Eigen::VectorXd::Zero(d), Eigen::VectorXd::Ones(d),
                                         errors_of(peak, calls), start, errors);
      INFO("d = " << d << ", seed " << seed);
      CHECK(climbs.errors[0] > 0.9);
      CHECK(climbs.errors[0] == peak.height(climbs.points.col(0)));
      CHECK(calls <= 10 * (2 * d + 8));
    }
  }
}

TEST_CASE("climbs stay in the box, and where a coordinate has no width") {
  const ErrorsAt errors_at = [](const Eigen::MatrixXd& points) {
    return Eigen::VectorXd((points.colwise().sum().array() + 10.0).transpose());
  };
  const Eigen::Vector3d lower(-1.0, 5.0, 0.0), upper(1.0, 5.0, 2.0);
  Eigen::MatrixXd starts(3, 2);
  starts << 0.0, -1.0,  //
      7.0, 6.0,         //
      1.0, 0.0;
  const Climbs climbs = climb_errors(lower, upper, errors_at, starts, errors_at(starts));
  for (Eigen::Index j = 0; j < 2; ++j) {
    CHECK(climbs.points(1, j) == starts(1, j));
    CHECK(climbs.points(0, j) == 1.0);
    CHECK(climbs.points(2, j) == 2.0);
  }
}

TEST_CASE("a climb never ends lower than it began, and zero errors are no obstacle") {
  const ErrorsAt nothing = [](const Eigen::MatrixXd& points) {
    return Eigen::VectorXd(Eigen::VectorXd::Zero(points.cols()));
  };
  const Eigen::MatrixXd start = Eigen::MatrixXd::Constant(3, 1, 0.5);
  const Climbs climbs = climb_errors(Eigen::VectorXd::Zero(3), Eigen::VectorXd::Ones(3), nothing, start,
                                     Eigen::VectorXd::Constant(1, 1e-9));
  CHECK(climbs.errors[0] == 1e-9);
  CHECK(climbs.points == start);
}

TEST_CASE("errors have outliers where the largest is so many times the 95 % quantile") {
  Eigen::VectorXd errors = Eigen::VectorXd::LinSpaced(200, 0.5, 1.0);
  CHECK_FALSE(has_outliers(errors, 2.0));
  errors[17] = 9.0;
  CHECK(has_outliers(errors, 4.0));
  CHECK_FALSE(has_outliers(errors, 10.0));
  CHECK_FALSE(has_outliers(Eigen::VectorXd(), 4.0));
  // A single error is its own quantile.
  CHECK_FALSE(has_outliers(Eigen::VectorXd::Ones(1), 4.0));
}
