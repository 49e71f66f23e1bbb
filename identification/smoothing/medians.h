#pragma once

#include <vector>

#include <Eigen/Core>

/// Internal to identification/ and motion/.
namespace samara::identification {

/// Median, of an even number the mean of the two in the middle; NaN if there is none.
double median(std::vector<double> values);

/// Median of the intervals between frames, s.
double median_interval(const Eigen::VectorXd& times);

}  // namespace samara::identification
