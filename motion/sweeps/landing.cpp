#include "samara/motion/sweeps/landing.h"

#include <cmath>
#include <limits>

namespace samara::motion {

namespace {

constexpr double kNotTold = std::numeric_limits<double>::quiet_NaN();

LandingStatistics statistics_of(Pattern pattern, const std::vector<Eigen::Vector3d>& landed) {
  LandingStatistics s;
  s.pattern = pattern;
  s.falls = static_cast<int>(landed.size());
  s.mean_error.setConstant(kNotTold);
  s.covariance.setConstant(kNotTold);
  s.distance_error = kNotTold;
  if (landed.empty()) {
    s.mean.setConstant(kNotTold);
    s.distance = s.time = kNotTold;
    return s;
  }
  const double n = static_cast<double>(landed.size());
  double squares = 0.0;
  for (const Eigen::Vector3d& one : landed) {
    s.mean += one.head<2>() / n;
    s.distance += one.head<2>().norm() / n;
    squares += one.head<2>().squaredNorm() / n;
    s.time += one.z() / n;
  }
  if (landed.size() < 2) return s;
  s.covariance.setZero();
  for (const Eigen::Vector3d& one : landed)
    s.covariance += (one.head<2>() - s.mean) * (one.head<2>() - s.mean).transpose() / (n - 1.0);
  s.mean_error = (s.covariance.diagonal() / n).cwiseSqrt();
  s.distance_error = std::sqrt(std::max(0.0, squares - s.distance * s.distance) / (n - 1.0));
  return s;
}

}  // namespace

std::vector<LandingStatistics> landing_statistics(const Sweep& sweep, Eigen::Index release) {
  std::vector<std::vector<Eigen::Vector3d>> landed(kPatterns);
  std::vector<int> counts(kPatterns, 0);
  int total = 0;
  for (Eigen::Index n = 0; n < sweep.fall_count(); ++n) {
    if (sweep.release_of(n) != release) continue;
    const auto pattern = static_cast<std::size_t>(sweep.labels[static_cast<std::size_t>(n)].pattern);
    ++counts[pattern];
    ++total;
    if (std::isfinite(sweep.landing(n, 0))) landed[pattern].push_back(sweep.landing.row(n));
  }
  std::vector<LandingStatistics> all;
  for (std::size_t k = 0; k < kPatterns; ++k) {
    if (counts[k] == 0) continue;
    all.push_back(statistics_of(static_cast<Pattern>(k), landed[k]));
    all.back().share = counted_share(counts[k], total);
  }
  return all;
}

}  // namespace samara::motion
