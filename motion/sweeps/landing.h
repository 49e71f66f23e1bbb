#pragma once

#include <vector>

#include "samara/motion/patterns/share.h"
#include "samara/motion/sweeps/sweep.h"

namespace samara::motion {

/// Where the falls of one pattern land, measured from the point of release: what the dissertation draws from formulas
/// (3.9), (3.10). In the world's axes, so that the azimuth of the release shows. NaN is what so few falls do not tell:
/// errors and covariance of fewer than two, means of none. In a refined sweep shares and means are those of its points,
/// which crowd at borders, not of the box, and inherited falls land nowhere.
struct LandingStatistics {
  Pattern pattern = Pattern::unresolved;
  int falls = 0;  ///< that landed
  Share share;  ///< of all falls of the release that have this pattern; of a grid its interval is too narrow
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();        ///< m
  Eigen::Vector2d mean_error = Eigen::Vector2d::Zero();  ///< m, standard error
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< m^2
  double distance = 0.0, distance_error = 0.0;  ///< m, mean from the release, with its standard error
  double time = 0.0;                            ///< s, mean
};

/// One for each pattern that fell, in the order of pattern_names().
std::vector<LandingStatistics> landing_statistics(const Sweep& sweep, Eigen::Index release);

}  // namespace samara::motion
