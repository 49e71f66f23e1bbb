#include "samara/pgd/sampling/leja.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/base/require.h"

namespace samara::pgd {

namespace {

/// Derivative of the logarithm of the product of distances at x: decreasing between neighbouring points.
double log_slope(const Eigen::VectorXd& points, Eigen::Index count, double x) {
  double sum = 0.0;
  for (Eigen::Index j = 0; j < count; ++j) sum += 1.0 / (x - points[j]);
  return sum;
}

/// The maximum between two neighbouring points, by bisection of the slope.
double maximum_between(const Eigen::VectorXd& points, Eigen::Index count, double lower, double upper) {
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (lower + upper);
    (log_slope(points, count, middle) > 0.0 ? lower : upper) = middle;
  }
  return 0.5 * (lower + upper);
}

double log_product(const Eigen::VectorXd& points, Eigen::Index count, double x) {
  return (x - points.head(count).array()).abs().log().sum();
}

Eigen::VectorXd make_points() {
  Eigen::VectorXd points(kMostLejaPoints);
  points.head(3) << 1.0, -1.0, 0.0;
  for (Eigen::Index count = 3; count < points.size(); ++count) {
    Eigen::VectorXd sorted = points.head(count);
    std::sort(sorted.begin(), sorted.end());
    double best = 0.0;
    double best_product = -std::numeric_limits<double>::infinity();
    // From the right, and a left one must be better by more than rounding: the sequence is then the same
    // everywhere.
    for (Eigen::Index j = count - 1; j > 0; --j) {
      const double x = maximum_between(points, count, sorted[j - 1], sorted[j]);
      const double product = log_product(points, count, x);
      if (product > best_product + 1e-9) {
        best = x;
        best_product = product;
      }
    }
    points[count] = best;
  }
  return points;
}

}  // namespace

Eigen::VectorXd leja_points(int count) {
  static const Eigen::VectorXd points = make_points();
  require(count >= 1 && count <= kMostLejaPoints, "the number of Leja points", count,
          fmt::format("1 to {}", kMostLejaPoints));
  return points.head(count);
}

}  // namespace samara::pgd
