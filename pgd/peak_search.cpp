#include "samara/pgd/peak_search.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace samara::pgd {

namespace {

double median(const Eigen::RowVectorXd& values) {
  std::vector<double> sorted(values.begin(), values.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

/// Root mean square about the median over the scale, per output.
Eigen::VectorXd spread(const Eigen::MatrixXd& values, const Eigen::VectorXd& scale) {
  Eigen::VectorXd result(values.rows());
  for (Eigen::Index m = 0; m < values.rows(); ++m) {
    const double centre = median(values.row(m));
    result[m] = std::sqrt((values.row(m).array() - centre).square().mean()) / scale[m];
  }
  return result;
}

/// One climb: the objective is |output m - ground|.
Eigen::VectorXd climb(const std::vector<SampledCoordinate>& coordinates, SampledFunction& function,
                      Eigen::Index m, double ground, Eigen::VectorXd x) {
  constexpr int kSweeps = 6;
  double step = 0.25;  // of the intervals
  double height = std::abs(function.recalled(x)(m, 0) - ground);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool gained = false;
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const SampledCoordinate& c = coordinates[static_cast<std::size_t>(k)];
      Eigen::MatrixXd sides = x.replicate(1, 2);
      const double way = step * (c.upper - c.lower);
      sides(k, 0) = std::max(x[k] - way, c.lower);
      sides(k, 1) = std::min(x[k] + way, c.upper);
      Eigen::Index side = 0;
      const double higher = (function.recalled(sides).row(m).array() - ground).abs().maxCoeff(&side);
      if (!(higher > height)) continue;
      height = higher;
      x = sides.col(side);
      gained = true;
    }
    if (!gained || sweep > 0) step *= 0.5;
  }
  return x;
}

}  // namespace

bool looks_like_peaks(const Eigen::MatrixXd& values, const Eigen::VectorXd& scale) {
  constexpr double kHardly = 0.02;
  const Eigen::VectorXd spreads = spread(values, scale);
  // An output that is constant altogether has no peaks.
  return (spreads.array() > 0.0 && spreads.array() < kHardly).any();
}

Eigen::MatrixXd climb_peaks(const std::vector<SampledCoordinate>& coordinates, SampledFunction& function,
                            const Eigen::MatrixXd& values, int climbs, Random& random) {
  const Eigen::VectorXd spreads = spread(values, function.scale());
  Eigen::Index output = 0;
  (spreads.array() > 0.0).select(spreads, 1.0).minCoeff(&output);
  const double ground = median(values.row(output));
  Eigen::MatrixXd ends(static_cast<Eigen::Index>(coordinates.size()), climbs);
  for (Eigen::Index j = 0; j < climbs; ++j) {
    Eigen::VectorXd start(ends.rows());
    for (Eigen::Index k = 0; k < start.size(); ++k) {
      const SampledCoordinate& c = coordinates[static_cast<std::size_t>(k)];
      start[k] = c.lower + (c.upper - c.lower) * random.uniform();
    }
    ends.col(j) = climb(coordinates, function, output, ground, start);
  }
  return ends;
}

}  // namespace samara::pgd
